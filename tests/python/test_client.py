"""The client against a real server: arrays, batches, context managers."""
import numpy as np
import pytest

import stiefel

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}


@pytest.fixture
def session(client):
    with client.create(SCENE) as session:
        yield session


def test_a_trajectory_is_arrays(session):
    run = session.trajectory(to=1000, every=7, fields=["Q", "quaternion"])
    assert list(run.step) == [*range(0, 1000, 7), 1000] and run.step.dtype == np.int64
    assert (run.time == run.step * 0.01).all()
    assert run["Q"].shape == (run.samples, 3, 3) and run["quaternion"].shape == (run.samples, 4)
    assert run.outcome is stiefel.Outcome.REACHED and run.computed_steps == 1000
    assert (run["Q"][-1] == session.step(to=1000, fields="Q")["Q"]).all()


@pytest.mark.parametrize("system", ["rigid_body", "moser_veselov"])
@pytest.mark.parametrize("members", [None, 3])
def test_what_comes_by_default_is_what_the_scene_was_given_in(client, system, members):
    """Quaternion and angular velocity with `body`; otherwise the system's blocks."""
    scene = {**SCENE, "system": system}
    if system == "moser_veselov":
        del scene["method"]
    given = ["quaternion", "angular_velocity"]
    with client.create({**scene, "members": members} if members else scene) as session:
        state, lead = session.step(to=9), (members,) if members else ()
        assert list(state) == given and [state[name].shape for name in given] == [(*lead, 4), (*lead, 3)]
        first = session.step(to=0)
        np.testing.assert_allclose(first["quaternion"], np.tile([1.0, 0, 0, 0], (*lead, 1)), atol=1e-15)
        np.testing.assert_allclose(first["angular_velocity"], np.tile([0.1, 2, 0.1], (*lead, 1)), rtol=1e-3)
        assert list(session.trajectory(to=9).fields) == list(next(session.stream(to=9)).fields) == given
        event = {"field": "angular_velocity", "coefficients": [1, 0, 0], "level": 1e9}
        assert list(session.events(9, event).fields) == given and session.step_price.bytes == 7 * 8 * (members or 1)
        with session.drive() as drive:
            assert list(drive.step(9)) == given and list(drive.step(9, fields="Q")) == ["Q"]
        if system == "rigid_body":
            assert list(session.trajectory(times=[0.015]).fields) == given
        if members is None and system == "rigid_body":
            blocks = {name: session.step(to=9, fields=name)[name] for name in ("Q", "M")}
            with client.create({**scene, "body": None, "inertia": [2, 1, 0], "initial": blocks}) as other:
                assert list(other.step(to=1)) == ["Q", "M"]


def test_times_are_the_server_s(session):
    from stiefel import v1 as pb

    replies = session._connection.stub.Stream(pb.StreamRequest(session_id=session.id, to=3000, every=7))
    times = [time for reply in replies for time in reply.times]
    assert list(session.trajectory(to=3000, every=7).time) == times


def test_arrays_are_views_of_the_bytes(session):
    array = session.step(to=1)["quaternion"]
    assert not array.flags.writeable and not array.flags.owndata


def test_drive_has_the_bits_of_step(session):
    with session.drive(fields=["Q"]) as drive:
        states = [drive.step(k) for k in range(50)]
    assert [state.step for state in states] == list(range(50))
    assert (states[-1]["Q"] == session.step(to=49, fields="Q")["Q"]).all() and set(states[-1].fields) == {"Q"}


def test_the_estimated_error_is_that_of_the_closed_form(client, session):
    assert session.diagnose(to=1000).estimated_error is None
    error = session.diagnose(to=1000, estimate_error=True).estimated_error
    with client.create({**SCENE, "method": {"name": "exact"}}) as exact:
        ours, theirs = (each.step(to=1000, fields="Q")["Q"] for each in (session, exact))
    assert error.attitude == pytest.approx(np.abs(ours - theirs).max(), rel=1e-6) and error.attitude > 1e-5
    assert error.angle == pytest.approx(np.arccos((np.trace(ours.T @ theirs) - 1) / 2), rel=1e-4)
    assert error.momentum > 0 and error.missing == "" and error.member is None
    assert "closed form" in error.reference and error.reference_error < 1e-12


@pytest.mark.parametrize("address, fault", [
    ("localhost:99999", "the port 99999 is not between 1 and 65535"), ("localhost:0", "the port 0 is not between"),
    ("localhost", "the port is missing"), (":1", "the host is missing"), ("localhost:http", "the port 'http' is not a number"),
    ("::1:50551", "in brackets, [IPv6]:PORT"), ("http://localhost:50551", "without 'http://'"), ("not a host:1", "HOST:PORT or unix:PATH"),
    ("unix:", "the socket's path is missing"), ("unix:" + 108 * "x", "longer than 107 bytes")])
def test_what_cannot_be_an_address_is_refused(address, fault):
    with pytest.raises(stiefel.InvalidArgument) as caught:
        stiefel.Client(address)
    assert caught.value.message.startswith(f"cannot reach {address}: ") and fault in caught.value.message
