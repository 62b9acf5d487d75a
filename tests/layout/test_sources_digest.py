"""The digest of the engine's sources, which is part of the numerics id: it changes with each file that is compiled or
included, and with no other."""
from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]


def digest(engine: Path, folder: Path) -> str:
    header = folder / "sources_digest.h"
    subprocess.run(["cmake", f"-DENGINE={engine}", f"-DOUTPUT={header}", "-P", ROOT / "engine/sources_digest.cmake"],
                   check=True)
    found = re.fullmatch(r'#define STIEFEL_SOURCES_DIGEST "([0-9a-f]{16})"\n', header.read_text())
    assert found, header.read_text()
    return found[1]


def test_it_changes_with_each_source_and_with_nothing_else(tmp_path: Path) -> None:
    engine = Path(shutil.copytree(ROOT / "engine", tmp_path / "engine"))
    before = digest(engine, tmp_path)
    for suffix in (".cc", ".h", ".cc.in", ".inc"):
        path = max(engine.rglob(f"*{suffix}"))
        text = path.read_text()
        path.write_text(text + "\n")
        assert digest(engine, tmp_path) != before, path
        path.write_text(text)
    for name in ("README.md", "CMakeLists.txt", "notes.md"):
        (engine / name).write_text("another text\n")
    assert digest(engine, tmp_path) == before
    path.rename(path.with_name("renamed.inc"))
    assert digest(engine, tmp_path) != before


def test_every_source_that_git_knows_has_a_suffix_that_counts() -> None:
    known = subprocess.run(["git", "-C", ROOT, "ls-files", "engine"], capture_output=True, text=True).stdout.split()
    others = {path for path in known if not re.search(r"\.(cc|h|cc\.in|inc)$|/README\.md$", path)}
    assert others <= {"engine/CMakeLists.txt", "engine/stiefelConfig.cmake", "engine/sources_digest.cmake"}
