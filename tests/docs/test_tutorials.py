"""Each tutorial runs from its first cell to its last, and checks what it says."""
import sys
from pathlib import Path

import nbformat
import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs/site"))
import tutorials  # noqa: E402

NOTEBOOKS = sorted((ROOT / "docs/tutorials").glob("*.ipynb"))


def test_the_index_has_every_tutorial():
    index = (ROOT / "docs/tutorials/README.md").read_text(encoding="utf-8")
    assert NOTEBOOKS and [path.name for path in NOTEBOOKS if f"]({path.name})" not in index] == []


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_is_committed_without_results_and_asserts_something(path):
    cells = [cell for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)
    assert any("assert " in cell.source for cell in cells)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(path, tmp_path):
    made = tutorials.executed(path)
    assert [output.text for cell in made.cells if cell.cell_type == "code" for output in cell.outputs if output.get("name") == "stderr"] == []
    text = tutorials.page(made, tmp_path, path.stem)
    assert text.startswith("# ") and "```text\n" in text
