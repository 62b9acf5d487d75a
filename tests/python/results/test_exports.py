"""Exports read back: by the formulas of their standards, and by spiceypy where it is installed."""
import datetime
import re

import numpy as np
import pytest

import stiefel
from stiefel._exports.nodes import nodes_of
from stiefel._exports.spice import seconds_past_j2000
from stiefel._given.instants import instant
from stiefel._results.body import quaternions

EPOCH = "2026-03-01T23:59:58.25 UTC"
BODY = {"system": "rigid_body", "step": 0.1, "epoch": EPOCH,
        "body": {"inertia_tensor": [1.0, 2, 3, 0.1, 0.05, -0.2], "angular_velocity": [0.3, 1, 0.2], "attitude": [0.5, -0.5, 0.5, 0.5]}}
MADE = datetime.datetime(2026, 3, 2)
FIELDS = ["quaternion", "angular_velocity", "Q", "angular_velocity_space"]


def angle_between(first, second):
    """The angles in radians between attitudes as unit quaternions."""
    return 4 * np.arcsin(np.minimum(np.linalg.norm(first - second, axis=-1), np.linalg.norm(first + second, axis=-1)) / 2)


@pytest.fixture(scope="module")
def session(client):
    with client.create(BODY) as session:
        yield session


@pytest.fixture(scope="module")
def run(session):
    return session.trajectory(to=60, every=2, fields=FIELDS)


def keywords(text):
    return dict(re.findall(r"^(\w+) = (.*)$", text, re.M))


def ccsds_matrix(q1, q2, q3, qc):
    """The matrix of CCSDS 504.0 that takes coordinates in frame A to those in frame B."""
    return np.array([[q1 * q1 - q2 * q2 - q3 * q3 + qc * qc, 2 * (q1 * q2 + q3 * qc), 2 * (q1 * q3 - q2 * qc)],
                     [2 * (q1 * q2 - q3 * qc), -q1 * q1 + q2 * q2 - q3 * q3 + qc * qc, 2 * (q2 * q3 + q1 * qc)],
                     [2 * (q1 * q3 + q2 * qc), 2 * (q2 * q3 - q1 * qc), -q1 * q1 - q2 * q2 + q3 * q3 + qc * qc]])


def test_an_aem_has_the_attitudes(run, tmp_path):
    export = run.to_aem(tmp_path / "run.aem", object_name="CUBE", object_id="2026-001A", center="EARTH", created=MADE)
    text = (tmp_path / "run.aem").read_text()
    head = keywords(text)
    assert text.startswith("CCSDS_AEM_VERS = 2.0\n") and head["CREATION_DATE"] == "2026-03-02T00:00:00"
    assert head["ATTITUDE_TYPE"] == "QUATERNION/ANGVEL" and head["ANGVEL_FRAME"] == "SC_BODY_1" and head["REF_FRAME_A"] == "EME2000" and head["TIME_SYSTEM"] == "UTC"
    assert head["START_TIME"] == "2026-03-01T23:59:58.25" and head["OBJECT_NAME"] == "CUBE" and head["CENTER_NAME"] == "EARTH"
    rows = [line.split() for line in text.split("DATA_START\n")[1].split("\nDATA_STOP")[0].splitlines()]
    assert len(rows) == 31 and rows[-1][0] == head["STOP_TIME"] == "2026-03-02T00:00:04.25"
    for row, Q in zip(rows, run["Q"]):
        np.testing.assert_allclose(ccsds_matrix(*map(float, row[1:5])), Q.T, atol=1e-15)
    np.testing.assert_allclose(np.radians([[float(x) for x in row[5:]] for row in rows]), run["angular_velocity"], rtol=1e-15)
    assert export.samples == 31 and export.time_rounding < 1e-12 and f"COMMENT times rounded by at most {export.time_rounding:.1e} s" in text
    assert len(repr(export).splitlines()) == 2


def test_a_continuous_sign(run):
    flipped = stiefel.Trajectory(run.step, run.time, {**run.fields, "quaternion": run["quaternion"] * (-1.0) ** run.step[:, None]}, run.run_status)
    nodes, others = nodes_of(run), nodes_of(stiefel.Trajectory(run.step, run.time, {"Q": run["Q"]}, run.run_status), EPOCH)
    for other in (nodes_of(flipped, EPOCH), others):
        assert angle_between(other.quaternion, nodes.quaternion).max() < 1e-14
        assert ((other.quaternion[1:] * other.quaternion[:-1]).sum(axis=1) > 0).all()
    assert others.rate is None and (nodes.rate == run["angular_velocity"]).all()
    back = nodes_of(run[::-1])
    assert (back.time == nodes.time).all() and (abs(back.quaternion) == abs(nodes.quaternion)).all()


def test_what_is_missing_is_said(client, run, tmp_path):
    without = stiefel.Trajectory(run.step, run.time, run.fields, run.run_status)
    with pytest.raises(ValueError, match="epoch: absent"):
        without.to_aem(tmp_path / "run.aem")
    without.to_aem(tmp_path / "run.aem", epoch=datetime.datetime(2026, 1, 1))
    with pytest.raises(ValueError, match="needs the field quaternion"):
        stiefel.Trajectory(run.step, run.time, {"M": run["Q"]}, run.run_status).to_aem(tmp_path / "other.aem", epoch=EPOCH)
    with client.create({**BODY, "members": 2}) as session, pytest.raises(ValueError, match="of an ensemble"):
        session.trajectory(to=1).to_aem(tmp_path / "other.aem")
    assert [path.name for path in tmp_path.iterdir()] == ["run.aem"]


def test_a_c_kernel_is_read_by_spice(run, tmp_path):
    spice = pytest.importorskip("spiceypy", reason="spiceypy is not installed; it comes from PyPI")
    export = run.to_ck(tmp_path / "run.bc", instrument=-999000)
    assert export.files == (str(tmp_path / "run.bc"), str(tmp_path / "run.tsc")) and export.time_rounding < 1e-6
    for kernel in export.files:
        spice.furnsh(kernel)
    try:
        begin = seconds_past_j2000(instant("epoch", EPOCH))
        for k in range(len(run)):
            ticks = spice.sce2c(-999, begin + run.time[k])
            matrix, rate, _ = spice.ckgpav(-999000, (run.time[k] - run.time[0]) * 1e6, 0.0, "J2000")
            assert abs(ticks - (run.time[k] - run.time[0]) * 1e6) < 1
            found = quaternions({"Q": matrix.T})
            assert angle_between(found, run["quaternion"][k]) < 1e-12
            np.testing.assert_allclose(rate, run["angular_velocity_space"][k], atol=1e-14)
    finally:
        spice.kclear()
