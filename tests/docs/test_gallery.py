"""Each script of the gallery draws its picture, in an empty folder, and asserts what it says."""
import ast
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.image import imread

ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "docs/gallery").glob("*.py"))
EXAMPLES = {"toutatis.py": [], "measure_tradeoff.py": [ROOT / "client/examples/scenes/tradeoff.json"]}


def assert_drawn(picture):
    """Something is on a white ground."""
    pixels = imread(picture)[..., :3]
    assert pixels.shape[0] >= 300 and pixels.shape[1] >= 400
    assert 0.01 < (abs(pixels - 1) > 0.1).any(axis=2).mean() < 0.99


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_a_picture(script, tmp_path):
    subprocess.run([sys.executable, script, tmp_path / "drawn.png"], check=True, cwd=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["drawn.png"]
    assert_drawn(tmp_path / "drawn.png")


@pytest.mark.parametrize("script", EXAMPLES)
def test_the_picture_of_an_example(script, tmp_path):
    subprocess.run([sys.executable, ROOT / "client/examples" / script, *EXAMPLES[script], "--output", tmp_path], check=True)
    picture, = tmp_path.glob("*.png")
    assert_drawn(picture)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.stem)
def test_its_program_fits_a_page_and_asserts_something(script):
    text = script.read_text(encoding="utf-8")
    assert any(isinstance(node, ast.Assert) for node in ast.walk(ast.parse(text))) and len(text.splitlines()) <= 60
