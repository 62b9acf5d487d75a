"""The main example, beside an integration that shares nothing with the engine."""
import json
import os
import re
import subprocess
import sys
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest


EXAMPLES = Path(__file__).parents[2] / "client" / "examples"
sys.path.insert(0, str(EXAMPLES))
import toutatis  # noqa: E402

DATA = json.loads(toutatis.DATA.read_text(encoding="utf-8"))


def independent_attitudes():
    """Classical Runge-Kutta of order 4 in days and radians on the rotation matrix, 400 steps a day: its
    error, seen by halving the step, is below 1e-6 degrees."""
    moments = np.array(DATA["moments"])

    def field(frame, momentum):
        x, y, z = omega = momentum / moments
        return frame @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.cross(momentum, omega)

    def step(state, h):
        slopes = [field(*state)]
        for weight in (h / 2, h / 2, h):
            slopes.append(field(*(part + weight * slope for part, slope in zip(state, slopes[-1]))))
        return tuple(part + h / 6 * (a + 2 * b + 2 * c + d) for part, a, b, c, d in zip(state, *slopes))

    epoch, now = datetime.fromisoformat(DATA["epoch"]), 0.0
    state = toutatis.attitude(DATA["euler"]), moments * np.radians(DATA["angular_velocity"])
    for observation in DATA["observations"]:
        then = (datetime.fromisoformat(observation["utc"]) - epoch).total_seconds() / toutatis.DAY
        count = int(np.ceil((then - now) * 400))
        for _ in range(count):
            state = step(state, (then - now) / count)
        now = then
        yield state[0]


@pytest.fixture(scope="module")
def session(client):
    with client.create(toutatis.scene(DATA)) as session:
        yield session


@pytest.fixture(scope="module")
def comparisons(session):
    return list(toutatis.compare(session, DATA))


def test_every_axis_is_where_an_independent_integration_puts_it(comparisons):
    assert len(comparisons) == 17
    for comparison, expected in zip(comparisons, independent_attitudes()):
        apart = comparison._replace(observed=expected).angles()
        assert apart.max() < 1e-4, comparison.utc  # degrees; the engine's own error at 1 s is below 1e-6


def test_the_observations_agree(comparisons):
    angles = np.array([comparison.angles() for comparison in comparisons])
    assert np.median(angles) <= 6 and np.median(angles.max(axis=1)) <= 6
    assert angles.max() < 20


def test_nothing_drifts_in_39_days(session):
    run = session.trajectory(to=toutatis.DAYS * toutatis.DAY, every=toutatis.SAMPLE, fields=["Q", "M"])
    energy, momentum = toutatis.drifts(run, DATA)
    # Plain arithmetic: the roundings of 3.4e6 steps, of random signs, add up to a few times u sqrt(3.4e6) = 2e-13.
    assert energy.max() <= 1e-12 and momentum.max() <= 1e-12
    energy, momentum = toutatis.drifts(run, {**DATA, "moments": [3.0, 3.235, 1.0]})
    assert energy.max() > 1e-3, "with other moments it is not the energy"


def run(script, *arguments, folder):
    return subprocess.run([sys.executable, EXAMPLES / script, *arguments], cwd=folder, capture_output=True,
                          text=True, env={**os.environ, "MPLCONFIGDIR": str(folder)})


def test_the_command(tmp_path):
    result = run("toutatis.py", "--output", "out", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert len(re.findall(r"^1992-12-\S+ +([\d.]+) +([\d.]+) +([\d.]+)$", result.stdout, re.MULTILINE)) == 17
    assert re.search(r"^5617 states in \S+ s, with the method exact$", result.stdout, re.MULTILINE)
    assert re.search(r"^estimated error of the last attitude: \S+e-\d\d degrees$", result.stdout, re.MULTILINE)
    with np.load(tmp_path / "out" / "trajectory.npz") as saved:
        assert saved["step"][-1] == 39 * 86400 and saved["Q"].shape == (5617, 3, 3)
    assert (tmp_path / "out" / "toutatis.png").read_bytes().startswith(b"\x89PNG")
