"""Exports read back: by the formulas of their standards, by spiceypy and by mcap where these are installed."""
import datetime
import json
import re

import numpy as np
import pytest

import stiefel
from stiefel._exports.nodes import nodes_of
from stiefel._exports.spice import seconds_past_j2000
from stiefel._given.instants import instant
from stiefel._results.attitude import angle_between, between, quaternions

EPOCH = "2026-03-01T23:59:58.25 UTC"
BODY = {"system": "rigid_body", "step": 0.1, "epoch": EPOCH,
        "body": {"inertia_tensor": [1.0, 2, 3, 0.1, 0.05, -0.2], "angular_velocity": [0.3, 1, 0.2], "attitude": [0.5, -0.5, 0.5, 0.5]}}
MADE = datetime.datetime(2026, 3, 2)
FIELDS = ["quaternion", "angular_velocity", "Q", "angular_velocity_space"]


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
    assert export.samples == 31 and export.time_rounding < 1e-12 and f"{export.interpolation_error:.1e} rad" in text
    assert len(repr(export).splitlines()) == 2
    assert nodes_of(run).interpolation_error() < export.interpolation_error < 0.1
    assert run[::10].to_aem(tmp_path / "coarse.aem").interpolation_error == np.pi  # more than 90 degrees from one to the next


def test_an_apm_has_one_state(run, tmp_path):
    assert repr(run.to_apm(tmp_path / "run.apm", at=3)).startswith("<stiefel.Export of 1 sample as CCSDS APM")
    found = keywords((tmp_path / "run.apm").read_text())
    np.testing.assert_allclose(ccsds_matrix(*(float(found[name]) for name in ("Q1", "Q2", "Q3", "QC"))), run["Q"][3].T, atol=1e-15)
    rates = [float(found[f"ANGVEL_{axis}"].split()[0]) for axis in "XYZ"]
    np.testing.assert_allclose(np.radians(rates), run["angular_velocity"][3], rtol=1e-15)
    assert found["EPOCH"] == "2026-03-01T23:59:58.85" and found["IXY"] == "0.1 [kg*m**2]" and found["ANGVEL_FRAME"] == "SC_BODY_1"


MOTIONS = {"a tensor": BODY["body"], "a flip": {"moments": [1, 2, 3], "angular_velocity": [1e-4, 1, 1e-4]},
           "a fast turn": {"moments": [1, 1.1, 2], "angular_velocity": [0.2, 0.1, 9]}, "a steady turn": {"moments": [1, 2, 3], "angular_velocity": [0, 0, 2]}}
GRIDS = {"even": np.arange(0, 60, 0.2), "coarse": np.arange(0, 120, 2.6), "next to each other": [0, 0.001, 4, 4.001, 9, 9.002, 13],
         "random": np.sort(np.random.default_rng(1).uniform(-20, 40, 200)), "two": [3, 3.4], "many turns": np.arange(0, 100, 2 * np.pi)}


def between_samples(session, nodes):
    """The largest angle between the motion and the shortest turns, at 15 times in each interval."""
    worst = 0.0
    for fraction in np.arange(1, 16) / 16:
        times = nodes.time[:-1] + fraction * np.diff(nodes.time)
        true = quaternions(session.trajectory(times=times, fields="quaternion").fields)
        found = between(nodes.quaternion[:-1], nodes.quaternion[1:], np.full(len(times), fraction))
        worst = max(worst, angle_between(true, found).max())
    return worst


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("motion", MOTIONS)
def test_between_two_samples_the_error_is_below_the_printed_one(client, motion, grid):
    """And not far below. A trajectory has no angular velocities here."""
    with client.create({**BODY, "body": MOTIONS[motion]}) as session:
        nodes = nodes_of(session.trajectory(times=GRIDS[grid], fields="quaternion"))
        worst = between_samples(session, nodes)
    assert worst <= nodes.interpolation_error() <= 1.3 * worst + 1e-12


def test_the_scene_may_have_other_variables(client):
    """The error follows from the scene, and is that of the same body."""
    scene = {"system": "rigid_body", "step": 0.2, "inertia": [3, 2, 1.5], "initial": {
        "Q": np.linalg.qr([[1, 2, 0], [0, 1, 1], [0.5, 0, 1]])[0], "M": [[0, -0.2, 4], [0.2, 0, -0.1], [-4, 0.1, 0]]}}
    scene["initial"]["Q"] *= np.linalg.det(scene["initial"]["Q"])
    expected = nodes_of(client.create(scene).trajectory(to=50), EPOCH).interpolation_error()
    for system in ("symmetric_rigid_body", "reduced_rigid_body", "mclachlan_scovel", "stiefel"):
        run = client.create(client.convert(scene, system).scene).trajectory(to=50)
        assert nodes_of(run, EPOCH).interpolation_error() == pytest.approx(expected, rel=1e-3), system


@pytest.mark.parametrize("grid", ["even", "next to each other", "random"])
@pytest.mark.parametrize("motion", ["a tensor", "a flip"])
def test_samples_alone_give_an_estimate_from_above(client, motion, grid):
    """Where a trajectory does not know its scene."""
    with client.create({**BODY, "body": MOTIONS[motion]}) as session:
        run = session.trajectory(times=GRIDS[grid], fields=["quaternion", "angular_velocity"])
        nodes = nodes_of(stiefel.Trajectory(run.step, run.time, run.fields, run.run_status), EPOCH)
        assert between_samples(session, nodes) <= nodes.interpolation_error()


def test_a_turn_by_more_than_half_a_turn_is_noticed(client):
    with client.create({**BODY, "body": MOTIONS["a steady turn"]}) as session:
        run = session.trajectory(times=np.arange(5) * np.pi, fields=["quaternion", "angular_velocity"])
    assert nodes_of(stiefel.Trajectory(run.step, run.time, run.fields, run.run_status), EPOCH).interpolation_error() == np.pi


def test_the_scene_tells_the_angular_velocities(client):
    """Those of the samples, in the caller's axes."""
    for other in (BODY, {**BODY, "body": {"moments": [2, 3, 4], "angular_velocity": [1, 0.3, 0.2]}}):
        with client.create(other) as session:
            run = session.trajectory(to=60, fields=["angular_velocity", "quaternion"])
        nodes = nodes_of(stiefel.Trajectory(run.step, run.time, {"quaternion": run["quaternion"]}, run.run_status, origin=run.origin))
        np.testing.assert_allclose(nodes.body_rate, run["angular_velocity"], rtol=0, atol=1e-13)


def test_rates_in_space_and_a_continuous_sign(run):
    flipped = stiefel.Trajectory(run.step, run.time, {**run.fields, "quaternion": run["quaternion"] * (-1.0) ** run.step[:, None]}, run.run_status)
    nodes, others = nodes_of(run), nodes_of(stiefel.Trajectory(run.step, run.time, {"Q": run["Q"]}, run.run_status), EPOCH)
    np.testing.assert_allclose(nodes.space_rate, run["angular_velocity_space"], atol=1e-14)
    for other in (nodes_of(flipped, EPOCH), others):
        assert angle_between(other.quaternion, nodes.quaternion).max() < 1e-14
        assert ((other.quaternion[1:] * other.quaternion[:-1]).sum(axis=1) > 0).all()
    assert others.space_rate is None
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


def test_a_leap_second_and_a_rounded_minute():
    from stiefel._exports.ccsds import _stamp

    assert _stamp(instant("epoch", "2016-12-31T23:59:59 UTC").after(1.5)) == "2016-12-31T23:59:60.5"
    assert _stamp(instant("epoch", "2026-01-01T00:00:59 UTC").after(1.0)) == "2026-01-01T00:01:00"


def test_seconds_of_spice():
    """Beside the values that its toolkit gives: str2et of 2000-01-01T12:00:00 UTC and of 2026-03-01T00:00:00 UTC."""
    assert seconds_past_j2000(instant("epoch", "2000-01-01T12:00:00 UTC")) == pytest.approx(64.183927, abs=1e-6)
    assert seconds_past_j2000(instant("epoch", "2000-01-01T12:00:00 TDB")) == 0
    with pytest.raises(ValueError, match="UT1"):
        seconds_past_j2000(instant("epoch", "2000-01-01T12:00:00 UT1"))


def test_a_c_kernel_is_read_by_spice(session, run, tmp_path):
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
        times = run.time[:-1] + 0.5 * np.diff(run.time)
        true = session.trajectory(times=times, fields="quaternion")["quaternion"]
        found = [quaternions({"Q": spice.ckgp(-999000, time * 1e6, 0.0, "J2000")[0].T}) for time in times]
        assert 0 < angle_between(np.array(found), true).max() <= export.interpolation_error
    finally:
        spice.kclear()


def test_an_mcap_is_read_by_mcap(run, tmp_path):
    reader = pytest.importorskip("mcap.reader", reason="mcap is not installed; it comes from PyPI")
    export = run.to_mcap(tmp_path / "run.mcap")
    with open(tmp_path / "run.mcap", "rb") as file:
        messages = [(channel.topic, message.log_time, json.loads(message.data)) for _, channel, message in reader.make_reader(file).iter_messages()]
    attitudes = [content for topic, _, content in messages if topic == "/attitude"]
    assert len(attitudes) == len(messages) / 2 == len(run) and export.time_rounding <= 5e-10
    for content, q in zip(attitudes, run["quaternion"]):
        assert abs(np.array([content["rotation"][axis] for axis in "wxyz"]) @ q) == pytest.approx(1, abs=1e-15)
    begin = datetime.datetime(2026, 3, 1, 23, 59, 58, 250000, datetime.timezone.utc).timestamp()
    assert [time / 1e9 for topic, time, _ in messages if topic == "/attitude"] == pytest.approx(list(begin + run.time), abs=1e-6)
    rates = [[content["vector"][axis] for axis in "xyz"] for topic, _, content in messages if topic == "/angular_velocity"]
    assert (np.array(rates) == run["angular_velocity"]).all()
