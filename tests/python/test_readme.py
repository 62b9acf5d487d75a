"""What the README says is what happens."""
import re
import subprocess
import sys
from pathlib import Path

import pytest

import catalogue_page
import scene_types
import stiefel

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(language):
    return re.search(rf"```{language}\n(.*?)```", README, re.DOTALL)[1]


def test_the_program_prints_what_is_shown(tmp_path):
    """From an empty folder."""
    program = block("python")
    assert len(program.splitlines()) == 12
    result = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stdout == block("text") and result.stderr == ""


@pytest.mark.parametrize("program", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_every_program_runs(program, tmp_path):
    result = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert result.returncode == 0 and result.stderr == "", result.stderr


def test_the_types_of_scenes_are_those_of_the_protocol_and_the_catalogue(client):
    held = ROOT / "client/python/stiefel/_given/typed.py"
    assert scene_types.text(client.describe()) == held.read_text(encoding="utf-8"), "see tests/python/scene_types.py"


def test_the_catalogue_page_is_what_the_server_says(client):
    assert catalogue_page.page(client.describe()) == (ROOT / "docs/catalogue.md").read_text(encoding="utf-8")


def test_the_readme_is_short():
    assert len(README.splitlines()) <= 150
