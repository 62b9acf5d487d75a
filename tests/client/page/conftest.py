"""Pages that the command writes."""
from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

import stiefel
from pages import EXAMPLES, Page


@pytest.fixture(scope="session")
def client():
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        yield client


@pytest.fixture
def report(tmp_path):
    """Runs `stiefel report` on a scene file, by default an example's, and returns the page."""
    def report(scene, to, *options, status=0):
        path = scene if isinstance(scene, Path) else EXAMPLES / f"{scene}.json"
        command = [os.environ["STIEFEL_CLI"], "report", path, "--to", str(to), *options, "--output", "page.html"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert done.returncode == status, done.stderr
        assert done.stdout == "wrote page.html\n" and not list(tmp_path.glob("*.part"))
        return Page(tmp_path / "page.html")
    return report
