"""Runs the command, and writes the scenes it reads."""
import json
import os
import pathlib
import subprocess
from dataclasses import dataclass

import numpy as np
import pytest

EXAMPLES = pathlib.Path(__file__).parents[3] / "client/examples/scenes"
SCENES = ["tumbling_spacecraft", "envisat", "rigid_body_8", "moser_veselov"]


@dataclass
class Result:
    status: int
    out: str
    err: str

    @property
    def json(self):
        return json.loads(self.out)


def matrix(rows):
    array = np.array(rows, dtype=float)
    return {"rows": array.shape[0], "cols": array.shape[1], "values": array.ravel().tolist()}


@pytest.fixture
def stiefel(tmp_path):
    def run(*arguments):
        done = subprocess.run([os.environ["STIEFEL_CLI"], *map(str, arguments)], cwd=tmp_path,
                              capture_output=True, text=True, timeout=300)
        return Result(done.returncode, done.stdout, done.stderr)
    return run


@pytest.fixture
def write(tmp_path):
    """Writes a scene, a dict or text, and gives its path."""
    def write(scene, name="scene.json"):
        path = tmp_path / name
        path.write_text(scene if isinstance(scene, str) else json.dumps(scene))
        return path
    return write


@pytest.fixture
def scene():
    """A tumbling body; a fresh dict to change."""
    return {
        "system": "rigid_body",
        "method": {"name": "variational"},
        "inertia": [2.5, 1.5, 0.5],
        "initial": {"Q": matrix(np.eye(3)),
                    "M": matrix([[0, -0.01, 3], [0.01, 0, -0.001], [-3, 0.001, 0]])},
        "step": 0.01,
    }


@pytest.fixture
def too_long(scene):
    """A step for which the map has no solution."""
    return {**scene, "step": 5.0}
