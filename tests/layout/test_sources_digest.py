"""The digest of the engine's sources, which is part of the numerics id: it changes with each file that is compiled or
included, and with no other."""
from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from layout import ROOT


def digest(engine: Path, folder: Path) -> str:
    header = folder / "sources_digest.h"
    subprocess.run(["cmake", f"-DENGINE={engine}", f"-DOUTPUT={header}", "-P", ROOT / "engine/sources_digest.cmake"],
                   check=True)
    found = re.fullmatch(r'#define STIEFEL_SOURCES_DIGEST "([0-9a-f]{16})"\n', header.read_text())
    assert found, header.read_text()
    return found[1]


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    return Path(shutil.copytree(ROOT / "engine", tmp_path / "engine"))


def files(engine: Path, suffix: str) -> list[Path]:
    return sorted(path for path in engine.rglob("*") if path.name.endswith(suffix))


@pytest.mark.parametrize("suffix", [".cc", ".h", ".cc.in", ".inc"])
def test_a_changed_source_changes_it(suffix: str, copy: Path, tmp_path: Path) -> None:
    before = digest(copy, tmp_path)
    for path in (files(copy, suffix)[0], files(copy, suffix)[-1]):
        text = path.read_text()
        path.write_text(text + "\n")
        assert digest(copy, tmp_path) != before, path
        path.write_text(text)
    assert digest(copy, tmp_path) == before


def test_a_new_a_lost_and_a_renamed_source_change_it(copy: Path, tmp_path: Path) -> None:
    found = {digest(copy, tmp_path)}
    (copy / "catalogue/new.h").touch()
    found.add(digest(copy, tmp_path))
    (copy / "catalogue/new.h").rename(copy / "catalogue/newer.h")
    found.add(digest(copy, tmp_path))
    files(copy, ".cc")[0].unlink()
    found.add(digest(copy, tmp_path))
    assert len(found) == 4


def test_nothing_else_changes_it(copy: Path, tmp_path: Path) -> None:
    before = digest(copy, tmp_path)
    for name in ("README.md", "CMakeLists.txt", "notes.md"):
        (copy / name).write_text("another text\n")
    assert digest(copy, tmp_path) == before


def test_every_source_that_git_knows_has_a_suffix_that_counts() -> None:
    known = subprocess.run(["git", "-C", ROOT, "ls-files", "engine"], capture_output=True, text=True).stdout.split()
    others = {path for path in known if not re.search(r"\.(cc|h|cc\.in|inc)$", path)}
    assert others <= {"engine/CMakeLists.txt", "engine/README.md", "engine/stiefelConfig.cmake", "engine/eigen_copy.cmake",
                      "engine/sources_digest.cmake", "engine/methods/all_methods.h.in"}  # the last one is for tests
