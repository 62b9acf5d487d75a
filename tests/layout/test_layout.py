"""No folder has too many files, no name is in too many folders, and no file includes against the order of the folders."""
from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from layout import ENGINE, ENGINE_FOLDERS, OTHERS, ROOT, arrows_against_the_order, large_folders, repeated_names, sources


def test_no_arrow_against_the_order():
    assert not (wrong := arrows_against_the_order()), "\n".join(map(str, wrong))


def test_no_folder_is_too_large():
    assert large_folders() == {}


def test_no_name_is_in_too_many_folders():
    assert repeated_names() == {}


def test_a_name_in_too_many_folders_is_found(tmp_path: Path):
    for file in ("engine/run/a.h", "engine/run/a.cc", "server/a.cc", "server/b.cc", "tests/a.py"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    assert repeated_names(tmp_path) == {"a": ["engine/run", "server", "tests"]}


def test_every_source_is_in_a_folder_of_the_order():
    folders = [*ENGINE_FOLDERS, *OTHERS]
    outside = [str(file) for file in sources(ROOT) if not any(str(file).startswith(f + "/") for f in folders)]
    assert outside == []
    assert len(list(sources(ROOT))) > 200


def test_an_entry_includes_neither_methods_nor_maps():
    entries = [file for file in sources(ROOT) if re.search(r"^SystemEntry \w+_entry\(\) {", (ROOT / file).read_text(), re.M)]
    assert len(entries) == 17
    outside = re.compile(r'#include "engine/(methods|stepping/ma|stepping/me|.*/(maps|passes|geodesics)|.*_maps\.h)')
    assert [str(file) for file in entries if outside.search((ROOT / file).read_text())] == []


@pytest.mark.parametrize("file, line", [
    ("engine/linalg/a.h", '#include "engine/methods/rk4.h"'),
    ("engine/run/a.h", "#include <google/protobuf/message.h>"),
    ("client/cpp/a.cc", '#include "server/calls/service.h"'),
])
def test_a_wrong_arrow_is_found(tmp_path: Path, file: str, line: str):
    (tmp_path / file).parent.mkdir(parents=True)
    (tmp_path / file).write_text(f"#pragma once\n\n{line}\n")
    assert [str(wrong) for wrong in arrows_against_the_order(tmp_path)] == [f"{file}:3: {line}"]


PICTURE = runpy.run_path(str(ROOT / "docs/architecture_picture.py"))["ORDER"]
# Folders without headers that the order of includes knows: the programs' own, and the public headers.
NOT_DRAWN = {"server", "engine/include/stiefel"}
# Folders in Python.
PYTHON = {"client/python", "client/examples"}
# Every row of the page's table names one folder or several of one parent.
PAGE = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")


def drawn() -> dict[str, tuple[int, int]]:
    """Returns the column and the row of each folder in docs/architecture.svg."""
    return {f"{parent}/{name}": (column, row) for column, (parent, names, _) in enumerate(PICTURE)
            for row, name in enumerate(names)}


def test_the_picture_has_every_folder_of_the_order():
    assert set(drawn()) == ({*ENGINE_FOLDERS, *OTHERS} - NOT_DRAWN) | PYTHON
    assert [folder for folder in drawn() if not (ROOT / folder).is_dir()] == []


def test_the_picture_has_the_engine_in_its_order():
    place = drawn()
    levels = [[place[folder] for folder in line] for line in ENGINE]
    for lower, higher in zip(levels, levels[1:]):
        assert max(column for column, _ in lower) <= min(column for column, _ in higher)


def test_the_picture_has_the_server_in_its_order():
    place = {folder: at for folder, at in drawn().items() if folder.startswith("server/")}
    wrong = []
    for folder, (column, row) in place.items():
        for allowed in OTHERS[folder]:
            # A rule for whole folders: server/(limits|sessions)/.* or server/sessions/.*
            whole = re.fullmatch(r"server/\(?([a-z|]+)\)?/\.\*", allowed)
            for other in whole[1].split("|") if whole else []:
                at = place[f"server/{other}"]
                if not (at[0] < column or (at[0] == column and at[1] < row)):
                    wrong.append(f"{folder} includes server/{other}")
    assert wrong == []


def test_the_page_has_every_folder_of_the_order():
    assert [folder for folder in OTHERS if folder != "server" and f"| `{folder}`" not in PAGE
            and f", `{folder}`" not in PAGE] == []
    names = re.findall(r"`([a-z_/]+)`", PAGE)
    assert [folder for folder in ENGINE_FOLDERS if folder not in names and folder.rsplit("/")[-1] not in names] == []


# No file compares with the name of a system or a method: what the library knows about one stands in its own file.
SYSTEMS = re.findall(r"^SYSTEM\((\w+)\)", (ROOT / "engine/catalogue/systems.inc").read_text(), re.M)
METHODS = [name for path in (ROOT / "engine/methods").glob("*.h")
           for name in re.findall(r'\.name = "(\w+)"', path.read_text())]
# Where names may stand: in the declaration of the system or method itself, in an entry's recommendations and the
# continuous system of a discrete one, and in the tables of counts.
OWN = re.compile(r'info\.name = |static constexpr const char\* name = |\.name = |\.method = "|entry\.continuous = "')
DATA = {"engine/catalogue/methods/step_weights.inc", "engine/catalogue/methods/workspaces.inc"}
# `exact` is also the name of a conservation.
CONSERVATION = 'return "exact";'


def quoted_names() -> list[str]:
    names = re.compile("|".join(f'"{name}"' for name in [*SYSTEMS, *METHODS]))
    found = []
    for file in sources(ROOT):
        if str(file) in DATA or file.parts[0] == "client":
            continue
        for number, line in enumerate((ROOT / file).read_text().splitlines(), 1):
            if names.search(line) and not OWN.search(line) and line.strip() != CONSERVATION:
                found.append(f"{file}:{number}: {line}")
    return found


def test_no_name_is_asked_for():
    # The name of the programs is also that of a system.
    assert len(SYSTEMS) >= 17 and len(METHODS) >= 10
    found = [line for line in quoted_names() if '"stiefel"' not in line or "system" in line]
    assert found == [], "\n".join(found)
