"""What the tests of sweeps share: a body, points, and chunks so small that a sweep has many."""
import functools
import json
import multiprocessing
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import stiefel

SCENE = {"system": "rigid_body", "step": 0.02, "method": {"name": "variational"},
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}}
SPINS = np.random.default_rng(7).normal(size=(60, 3))
MOMENTS = 3 + np.random.default_rng(8).random(size=(60, 3))
AXES = {"body.moments": MOMENTS, "body.angular_velocity": SPINS}
SUMMARIZE = {"quaternion": ["last", "max"], "energy": ["drift"]}
TO = 200


@pytest.fixture
def small_chunks(monkeypatch):
    """A sixteenth of the points a chunk, or fewer."""
    monkeypatch.setattr("stiefel._sweep.chunks.LARGEST", 4)


@pytest.fixture
def plain_result(monkeypatch):
    """`sweep` returns its own type, as where xarray is not installed."""
    monkeypatch.setattr("stiefel.SweepResult.to_xarray", _without_xarray)


def _without_xarray(self):
    raise ImportError("xarray")


def sweep(**options):
    return stiefel.sweep(**{"scene": SCENE, "axes": AXES, "to": TO, "summarize": SUMMARIZE, "zipped": True, **options})


def processes(workers, **options):
    """A pool of processes that are not forked: `can_fork` says why."""
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), **options)


FORK = """
import os, stiefel
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    client.describe()
    os.fork() or os._exit(0)
"""


@functools.cache
def can_fork():
    """Whether a process with a gRPC channel can fork: with the gRPC of Debian 13 `fork` never returns."""
    try:
        return subprocess.run([sys.executable, "-c", FORK], timeout=30, stderr=subprocess.DEVNULL).returncode == 0
    except subprocess.TimeoutExpired:
        return False


def failures(result):
    return json.loads(result.attrs["failures"])
