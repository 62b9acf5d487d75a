"""The site is built without a warning: it has all names of the Python package, of the protocol, the commands and the headers, and
each tutorial and each script of the gallery, which assert what they say, has run."""
from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stiefel
from stiefel.cli import options
from stiefel.v1 import simulation_pb2

ROOT = Path(__file__).parents[2]
BUILD = Path(os.environ["STIEFEL_SERVER"]).resolve().parents[1]


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    output = tmp_path_factory.mktemp("site")
    built = subprocess.run([sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", "-c", ROOT / "docs/site", "-d",
                            output / "doctrees", ROOT, output / "html"], capture_output=True, text=True)
    assert built.returncode == 0 and "WARNING" not in built.stderr, built.stdout + built.stderr
    return output / "html/docs/site"


def test_every_name_is_there(pages):
    entries = set(re.findall(r'id="stiefel\.[\w.]*?(\w+)"', (pages / "python.html").read_text(encoding="utf-8")))
    assert {name for name in dir(stiefel) if name[:1].isupper() and name != "SceneLike"} - entries == set()
    protocol = re.sub("<[^>]*>", "", (pages / "generated/protocol.html").read_text(encoding="utf-8"))
    service = simulation_pb2.DESCRIPTOR.services_by_name["SimulationService"]
    assert [method.name for method in service.methods if f"rpc {method.name}(" not in protocol] == []
    commands = (pages / "commands.html").read_text(encoding="utf-8")
    assert [name for name in options.COMMANDS if f"stiefel {name} [-h]" not in commands] == []
    assert "--max-sessions" in commands
    cpp = (pages / "generated/cpp.html").read_text(encoding="utf-8")
    headers = [*(ROOT / "engine/include").rglob("*.h"), *(ROOT / "client/cpp/include").rglob("*.h")]
    assert len(headers) > 20 and [header.name for header in headers if f"<h2>{header.name}<" not in cpp] == []


def test_the_gallery_is_drawn(pages):
    for script in (ROOT / "docs/gallery").glob("*.py"):
        assert "assert " in script.read_text(encoding="utf-8")
        page = (pages / f"generated/gallery/{script.stem}.html").read_text(encoding="utf-8")
        assert f"sphx_glr_{script.stem}_001.png" in page, script.stem


def test_tutorials_are_committed_without_results_and_assert_something(pages):
    index = (ROOT / "docs/tutorials/README.md").read_text(encoding="utf-8")
    for path in (ROOT / "docs/tutorials").glob("*.ipynb"):
        cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells), path
        assert any("assert " in line for cell in cells for line in cell["source"]) and f"]({path.name})" in index
        assert "nboutput" in (pages.parent / f"tutorials/{path.stem}.html").read_text(encoding="utf-8")
