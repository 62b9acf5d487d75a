"""astropy's Time, TimeDelta and Quantity in scenes and times, beside its own arithmetic; scipy's Rotation."""
from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
import tools

PROGRAM = """
import numpy as np
import stiefel
from astropy import units as u
from astropy.time import Time, TimeDelta
from scipy.spatial.transform import Rotation
from stiefel._exports.spice import seconds_past_j2000
from stiefel._given.instants import instant

EPOCH = Time("2016-12-31T23:59:30", scale="utc")
LATER = EPOCH + TimeDelta(np.array([-30.0, 0.0, 29.5, 31.0, 7200.25]), format="sec")
R = Rotation.from_euler("zxz", [145.498, 65.865, 241.524], degrees=True)


def scene(epoch):
    return stiefel.body_scene(moments=[2, 2, 1] * u.kg * u.m**2, attitude=R, angular_velocity=[1, 0, 3] * u.deg / u.s, epoch=epoch)


def check(epoch, times, expected, digits=1e-9):
    run = stiefel.simulate(scene(epoch), times=times, fields=["Q", "angular_velocity"])
    assert np.allclose(run.time, expected, rtol=0, atol=digits), (run.time, expected)
    # I = (2, 2, 1): omega_x = cos(omega_z t / 2), in degrees a second.
    turned = np.cos(np.radians(3) * np.asarray(expected) / 2)
    assert np.allclose(np.degrees(run["angular_velocity"][:, 0]), turned, rtol=0, atol=1e-8)
    return run


seconds = (LATER - EPOCH).sec
for given in (LATER, LATER.tai, LATER.tdb, list(LATER), LATER.isot, [str(one) for one in LATER.isot], (LATER - EPOCH), seconds * u.s,
              (seconds / 60) * u.min):
    check(EPOCH, given, seconds, 3e-3 if given is LATER.tdb else 1e-6)
tdb = Time("2026-03-01T00:00:00", scale="tdb")
check(tdb, tdb + TimeDelta([1.0, 5.0], format="sec"), [1, 5])
check(tdb, Time("2026-03-01T00:00:10", scale="tdb").utc.reshape(1), [10], 1e-6)
# A Time is days in two doubles, and yet a whole number of steps is one.
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for scale in ("tai", "utc", "tdb"):
        start = Time("2027-03-04T05:06:07.25", scale=scale)
        with client.create({**scene(start), "step": 0.1}) as session:
            for k in range(1, 4000, 7):
                assert session.step(time=start + k * 0.1 * u.s).step == session.step(time=k * 0.1 * u.s).step == k
                assert session.step(time=TimeDelta(k * 0.1, format="sec")).step == k
assert stiefel.simulate(scene(tdb), to=1).epoch == "2026-03-01T00:00:00 TDB"
check("2026-03-01T00:00:00 TDB", ["2026-03-01T00:00:10 TDB"], [10])
assert abs(seconds_past_j2000(instant("epoch", Time("2026-03-01T00:00:00"))) - seconds_past_j2000(instant("epoch", Time("2026-03-01T00:00:00").tdb))) < 3e-5
assert np.allclose(stiefel.simulate(scene(tdb), to=1, fields="Q")["Q"][0], R.as_matrix(), rtol=0, atol=1e-15)
try:
    check(tdb, ["2026-03-01T00:00:00 UTC"], [0])
except stiefel.InvalidArgument as error:
    assert "must be in the scale of the epoch 2026-03-01T00:00:00 TDB, or a Time of astropy" in str(error), error
else:
    raise AssertionError
print("right")
"""


@pytest.fixture(scope="session")
def programs() -> Path:
    return tools.from_pypi("astropy")


def test_times_and_quantities_of_astropy(programs, tmp_path):
    done = subprocess.run([programs / "python", "-c", PROGRAM], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0 and done.stdout == "right\n", done.stderr
