"""The site is built without a warning, and what it is made of is in it."""
from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stiefel

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs/site"
BUILD = Path(os.environ["STIEFEL_SERVER"]).resolve().parents[1]
sys.path.insert(0, str(SITE))
import command_pages  # noqa: E402
import protocol_pages  # noqa: E402


@pytest.fixture(scope="module")
def html(tmp_path_factory):
    output = tmp_path_factory.mktemp("site")
    built = subprocess.run([sys.executable, SITE / "build_site.py", BUILD, output], capture_output=True, text=True)
    assert built.returncode == 0 and "WARNING" not in built.stderr, built.stdout + built.stderr
    return output / "html"


def test_every_public_name_of_the_python_package_has_an_entry(html):
    pages = "".join(page.read_text(encoding="utf-8") for page in (html / "reference/python").glob("*.html"))
    entries = set(re.findall(r'id="stiefel\.([\w.]+)"', pages))
    wanted = {name for name in dir(stiefel) if not name.startswith("_") and name not in ("SceneLike", "solids")}
    assert wanted - {entry.split(".")[-1] for entry in entries} == set()


def test_every_message_and_call_of_the_protocol_has_a_heading(html):
    for file in protocol_pages.descriptors(ROOT / "proto"):
        page = (html / f"reference/protocol/{Path(file.name).stem}.html").read_text(encoding="utf-8")
        names = [*(message.name for message in file.message_type), *(f"enum {enum.name}" for enum in file.enum_type),
                 *(method.name for service in file.service for method in service.method)]
        assert [name for name in names if not re.search(rf"<h[23]>{name}<a", page)] == []


def test_every_command_is_shown(html):
    page = (html / "reference/commands/stiefel.html").read_text(encoding="utf-8")
    program = BUILD / "bin/stiefel"
    commands = command_pages.commands(subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout)
    assert {"run", "diagnose", "describe"} <= set(commands)
    assert [name for name in commands if f"<h2>stiefel {name}<a" not in page] == []


def test_every_public_header_is_shown(html):
    headers = [*(ROOT / "engine/include").rglob("*.h"), *(ROOT / "client/cpp/include").rglob("*.h")]
    assert len(headers) > 20
    for header in headers:
        name = str(header).partition("/include/")[2]
        page = (html / "reference/cpp" / (name.removesuffix(".h").replace("/", "_") + ".html")).read_text(encoding="utf-8")
        assert f"<h1>{name}<a" in page
