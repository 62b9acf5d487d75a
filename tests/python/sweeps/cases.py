"""What the tests of sweeps share: a body, points, and chunks so small that a sweep has many."""
import json

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
    monkeypatch.setattr("stiefel.sweeps.chunks.LARGEST", 4)


@pytest.fixture
def plain_result(monkeypatch):
    """`sweep` returns its own type, as where xarray is not installed."""
    monkeypatch.setattr("stiefel.sweeps.SweepResult.to_xarray", _without_xarray)


def _without_xarray(self):
    raise ImportError("xarray")


def sweep(**options):
    return stiefel.sweep(**{"scene": SCENE, "axes": AXES, "to": TO, "summarize": SUMMARIZE, "zipped": True, **options})


def failures(result):
    return json.loads(result.attrs["failures"])
