"""Each script of the gallery draws its picture, in an empty folder, and says what it shows."""
import ast
import sys
from pathlib import Path

import matplotlib
import pytest

matplotlib.use("Agg")
from matplotlib.image import imread  # noqa: E402

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs/site"))
import gallery  # noqa: E402

SCRIPTS = sorted((ROOT / "docs/gallery").glob("*.py"))


def assert_drawn(picture):
    """Something is on a white ground."""
    pixels = imread(picture)[..., :3]
    assert pixels.shape[0] >= 300 and pixels.shape[1] >= 400
    assert 0.01 < (abs(pixels - 1) > 0.1).any(axis=2).mean() < 0.99


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_picture(script, tmp_path):
    picture = tmp_path / f"{script.stem}.png"
    gallery.draw(script, picture)
    assert_drawn(picture)
    assert list(tmp_path.iterdir()) == [picture]


@pytest.mark.parametrize("name", gallery.LARGER)
def test_the_picture_of_an_example(name, tmp_path):
    gallery.draw_larger(name, tmp_path / f"{name}.png")
    assert_drawn(tmp_path / f"{name}.png")


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_its_program_fits_a_page_and_asserts_something(script):
    tree = ast.parse(script.read_text(encoding="utf-8"))
    assert len((ast.get_docstring(tree) or "").splitlines()) >= 3
    assert len(script.read_text(encoding="utf-8").splitlines()) <= 60
    assert any(isinstance(node, ast.Assert) for node in ast.walk(tree))
