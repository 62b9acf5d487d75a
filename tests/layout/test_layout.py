"""No folder has too many files, and no file includes against the order of the folders."""
from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from layout import ENGINE, ENGINE_FOLDERS, LARGEST_FOLDER, OTHERS, ROOT, arrows_against_the_order, large_folders, sources


def test_no_arrow_against_the_order():
    assert not (wrong := arrows_against_the_order()), "\n".join(map(str, wrong))


def test_no_folder_is_too_large():
    assert large_folders() == {}


def test_every_source_is_in_a_folder_of_the_order():
    folders = [*ENGINE_FOLDERS, *OTHERS]
    outside = [str(file) for file in sources(ROOT) if not any(str(file).startswith(f + "/") for f in folders)]
    assert outside == []
    assert len(list(sources(ROOT))) > 200


def test_the_page_on_the_architecture_has_every_folder_of_the_server():
    page = (ROOT / "docs/architecture.md").read_text()
    folders = [folder for folder in OTHERS if folder.startswith("server/")]
    assert [folder for folder in folders if f"\n| `{folder}` |" not in page] == []


@pytest.mark.parametrize("file, line", [
    ("engine/systems/a.h", '#include "engine/methods/rk4.h"'),
    ("engine/simulation/scene/a.cc", '#include "engine/simulation/catalogue/system_entry.h"'),
    ("engine/simulation/accuracy/a.cc", '#include "engine/simulation/conversion/phase.h"'),
    ("engine/include/stiefel/a.h", '#include "engine/linalg/arithmetic/scalar.h"'),
    ("engine/linalg/lie/a.h", '#include "stiefel/v1/scene.pb.h"'),
    ("engine/maps/a.h", "#include <google/protobuf/message.h>"),
    ("server/calls/a.cc", '#include "engine/simulation/run/ensemble.h"'),
    ("server/calls/a.cc", '#include "stiefel/scene.h"'),
    ("server/convert/a.cc", '#include "engine/simulation/run/ensemble.h"'),
    ("server/pricing/a.h", '#include "stiefel/v1/scene.pb.h"'),
    ("server/pricing/a.cc", '#include "server/convert/convert.h"'),
    ("server/sessions/a.cc", '#include "engine/systems/stiefel.h"'),
    ("server/sessions/a.cc", '#include "stiefel/v1/scene.pb.h"'),
    ("server/sessions/a.cc", "#include <grpcpp/grpcpp.h>"),
    ("server/sessions/a.cc", '#include "server/sessions/store/store.h"'),
    ("server/sessions/store/a.cc", '#include "stiefel/v1/scene.pb.h"'),
    ("client/cpp/a.cc", '#include "stiefel/scene.h"'),
    ("client/cli/a.cc", '#include "server/calls/service.h"'),
])
def test_a_wrong_arrow_is_found(tmp_path: Path, file: str, line: str):
    path = tmp_path / file
    path.parent.mkdir(parents=True)
    path.write_text(f"#pragma once\n\n{line}\n")
    found = arrows_against_the_order(tmp_path)
    assert [str(wrong) for wrong in found] == [f"{file}:3: {line}"]


def test_what_the_order_allows_is_allowed(tmp_path: Path):
    path = tmp_path / "engine/simulation/catalogue/a.cc"
    path.parent.mkdir(parents=True)
    path.write_text('#include "engine/simulation/catalogue/families/forms.h"\n#include "engine/systems/stiefel.h"\n'
                    '#include "stiefel/scene.h"\n#include "engine/linalg/arithmetic/to_text.h"\n#include <vector>\n')
    assert arrows_against_the_order(tmp_path) == []


def test_a_large_folder_is_found(tmp_path: Path):
    folder = tmp_path / "engine/maps"
    folder.mkdir(parents=True)
    for k in range(LARGEST_FOLDER + 1):
        (folder / f"m{k}.h").touch()
    assert large_folders(tmp_path) == {"engine/maps": LARGEST_FOLDER + 1}


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
