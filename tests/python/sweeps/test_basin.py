"""The example basin.py, beside an integration that shares nothing with the engine."""
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[3] / "client" / "examples"
sys.path.insert(0, str(EXAMPLES))
import basin  # noqa: E402

PIXELS = 6


def independent_flips():
    """Euler's equations by the classical Runge-Kutta method of order 4, all bodies at once, 4 steps for one of the
    engine's: its error in 100 s, seen by halving the step, is below 1e-6 rad/s."""
    I1, I2, I3 = basin.MOMENTS
    spins = basin.LARGEST * (2 * np.arange(PIXELS) + 1 - PIXELS) / PIXELS
    third, first = np.meshgrid(spins, spins, indexing="ij")
    spin = np.stack([first, np.ones_like(first), third])

    def field(w):
        return np.stack([(I2 - I3) / I1 * w[1] * w[2], (I3 - I1) / I2 * w[2] * w[0], (I1 - I2) / I3 * w[0] * w[1]])

    h, flips, last = basin.STEP / 4, np.zeros(first.shape, int), spin[1]
    for _ in range(basin.STEPS):
        for _ in range(4):
            a = field(spin)
            b = field(spin + h / 2 * a)
            c = field(spin + h / 2 * b)
            d = field(spin + h * c)
            spin = spin + h / 6 * (a + 2 * b + 2 * c + d)
        flips += spin[1] * last < 0
        last = spin[1]
    return flips


@pytest.fixture(scope="module")
def result():
    return basin.flips(PIXELS, basin.workers("cores"))


def test_bodies_turn_over_as_often_as_they_do_by_another_method(result):
    found = np.asarray(result["angular_velocity.sign_changes"])[:, :, 1]
    assert np.array_equal(found, independent_flips())
    assert found.min() > 5 and found.max() > 40 and np.asarray(result["energy.drift"]).max() < 1e-13


def test_the_program_writes_its_picture(tmp_path, result):
    said = subprocess.run([sys.executable, EXAMPLES / "basin.py", "--pixels", str(PIXELS), "--output", tmp_path],
                          check=True, capture_output=True, text=True).stdout
    assert f"SHA-256 of the result: {result.attrs['sha256']}" in said and said.startswith("36 bodies, 2000 steps each")
    assert (tmp_path / "basin.png").stat().st_size > 10_000


def test_where_it_computes_is_one_argument(client):
    assert basin.workers("cores") == {} and basin.workers("a:1,b:2") == {"servers": ["a:1", "b:2"]}
    assert basin.flips(2, basin.workers(client.address)).attrs["sha256"] == \
        basin.flips(2, {}).attrs["sha256"]
