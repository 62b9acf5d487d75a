"""What the tests of sweeps share: a body, points, and chunks so small that a sweep has many."""
import json
import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import stiefel

SCENE = {"system": "rigid_body", "step": 0.02, "method": {"name": "variational"},
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}}
WITHOUT_METHOD = {name: value for name, value in SCENE.items() if name != "method"}
SPINS = np.random.default_rng(7).normal(size=(60, 3))
MOMENTS = 3 + np.random.default_rng(8).random(size=(60, 3))
AXES = {"body.moments": MOMENTS, "body.angular_velocity": SPINS}
SUMMARIZE = {"quaternion": ["last", "max"], "energy": ["drift"]}
TO = 200


@pytest.fixture
def small_chunks(monkeypatch):
    """Fifteen chunks of four points."""
    monkeypatch.setattr("stiefel._sweep.plan.LARGEST", 4)


def sweep(**options):
    return stiefel.sweep(**{"scene": SCENE, "axes": AXES, "to": TO, "summarize": SUMMARIZE, "zipped": True, **options})


def processes(workers, **options):
    """A pool of processes that are not forked: with the gRPC of Debian 13 the fork of a process that has a channel never
    returns."""
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), **options)


def failures(result):
    return json.loads(result.attrs["failures"])


def methods(result):
    """That of each point."""
    known = json.loads(result.attrs["methods"])
    return [known[which] for which in result["method"].values.ravel()] if "method" in result else known
