"""ghz: many calls at once by reflection, each answered OK."""
from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

import stiefel
import tools
from script import SIZES, Json, scene_of_arrays


@pytest.fixture(scope="session")
def ghz() -> Path:
    return tools.from_go("ghz")


@pytest.fixture(scope="module")
def sessions(server: stiefel.Server) -> Any:
    """One of each size, by its size."""
    with stiefel.Client(server.address) as client:
        yield {size: client.create(scene_of_arrays(size)).id for size in SIZES}


# How many calls each, which have to fit into a minute of a loaded machine.
@pytest.mark.parametrize("rpc, size, count, request_", [
    ("Describe", 3, 2000, {}),
    ("Step", 3, 5000, {"to": 100}),
    ("Step", 64, 500, {"to": 3}),
    ("Step", 512, 20, {"to": 1, "fields": ["Q"]}),
    ("Drive", 3, 500, {"to": 50}),
    ("Stream", 3, 500, {"to": 200}),
    ("Stream", 512, 10, {"to": 1}),
    ("Diagnose", 64, 50, {"to": 3}),
], ids=str)
def test_a_load(ghz: Path, server: stiefel.Server, sessions: dict[int, str], rpc: str, size: int, count: int,
                request_: Json) -> None:
    request = {**request_, "session_id": sessions[size]} if rpc != "Describe" else {}
    done = subprocess.run([ghz, "--insecure", "--call", f"stiefel.v1.SimulationService.{rpc}", "--data", json.dumps(request),
                           "--total", str(count), "--concurrency", "10", "--timeout", "60s", "--format", "json", server.address],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    print(f"{rpc} at N = {size}: {report['rps']:.0f} calls a second, mean {report['average'] / 1e6:.2f} ms")
    assert report["statusCodeDistribution"] == {"OK": count}, report["errorDistribution"]
