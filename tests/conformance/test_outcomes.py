"""A numerical stop is an outcome with the last good state, not an error."""
import re

import numpy as np
import pytest

import scenes
from stiefel import Outcome


@pytest.fixture(scope="module")
def session(client):
    with client.create(scenes.left_domain()) as session:
        yield session


def test_step(session):
    state = session.step(to=10)
    assert state.outcome is Outcome.LEFT_DOMAIN
    assert state.step == 0 and (state["Q"] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]).all()
    assert 0 < state.run_status.largest_step < 5
    assert state.run_status.message


def test_the_largest_step_works_and_a_little_more_does_not(client, session):
    largest = session.step(to=1).run_status.largest_step
    for factor, outcome in ((0.99, Outcome.REACHED), (1.01, Outcome.LEFT_DOMAIN)):
        with client.create(scenes.rigid_body(step=largest * factor)) as other:
            assert other.step(to=1).outcome is outcome


def test_stream_ends_with_the_last_good_state(session):
    run = session.trajectory(to=10)
    assert run.outcome is Outcome.LEFT_DOMAIN
    assert list(run.step) == [0] and run["Q"].shape == (1, 3, 3)


def test_drive_goes_on(session):
    with session.drive() as drive:
        assert drive.step(3).outcome is Outcome.LEFT_DOMAIN
        assert drive.step(0).outcome is Outcome.REACHED


def test_diagnose(session):
    diagnosis = session.diagnose(to=10)
    assert diagnosis.step == 0
    assert diagnosis.run_status.largest_step > 0


def test_a_motion_that_overflows(client):
    """rk4 is far outside its region of stability, so that the numbers grow until they are not finite."""
    with client.create(scenes.rigid_body(method={"name": "rk4"}, step=40.0)) as session:
        state = session.step(to=100_000)
        assert state.outcome is Outcome.NOT_FINITE
        assert 0 <= state.step < 100_000
        assert session.step(to=state.step).outcome is Outcome.REACHED


def angles(message):
    """Returns the angles in degrees by which the requested and the largest step turn the body."""
    asked, largest = re.fullmatch(r"(?:member \d+: )?the (?:sub)?step of [\d.e+-]+ turns the body by ([\d.e+]+)° and has no "
                                  r"solution on the principal branch; the largest \|h\| that has one here is [\d.e+-]+, "
                                  r"which turns it by ([\d.e+]+)°.*", message).groups()
    return float(asked), float(largest)


def in_three_dimensions():
    variational = {"name": "variational"}
    frame = {**scenes.frame(3, 3), "step": 8.0}
    for name, scene in [
        ("rigid_body", scenes.left_domain()),
        ("backwards", scenes.rigid_body(step=-5.0)),
        ("order 4", scenes.rigid_body(step=5.0, method={"name": "variational", "order": 4})),
        ("order 10", scenes.rigid_body(step=5.0, method={"name": "preprocessed_variational", "order": 10})),
        ("substeps", scenes.rigid_body(step=9.0, method={"name": "variational", "substeps": 3})),
        ("moser_veselov", {**scenes.moser_veselov(), "step": 4.0}),
        ("right", scenes.rigid_body(system="right_rigid_body", method=variational, step=5.0)),
        ("symmetric", scenes.rigid_body(system="symmetric_rigid_body", method=variational, step=5.0)),
        ("momentum only", scenes.rigid_body(initial={"M": scenes.M3}, step=5.0)),
        ("stiefel", frame),
    ]:
        yield pytest.param(scene, id=name)


@pytest.mark.parametrize("scene", in_three_dimensions())
def test_in_three_dimensions_it_says_by_which_angle_a_step_turns(client, scene):
    """The message has h |omega| at the last good state, for the step and for the largest one that works."""
    with client.create(scene) as session:
        run_status = session.step(to=10).run_status
        last = session.step(to=10)
        assert run_status.outcome is Outcome.LEFT_DOMAIN
        if scene["system"] == "stiefel":
            Q, Qdot = (session.step(last.step, fields=[name])[name] for name in ("Q", "Qdot"))
            Omega = Q.T @ Qdot
        else:
            Omega = session.step(last.step, fields=["Omega"])["Omega"]
        speed = np.linalg.norm(Omega, 2)
        h = abs(scene["step"]) / scene.get("method", {}).get("substeps", 1)
        asked, largest = angles(run_status.message)
        assert asked == pytest.approx(np.degrees(h * speed), rel=6e-3)
        assert largest == pytest.approx(np.degrees(run_status.largest_step * speed), rel=6e-3)
        # Every call gives this message.
        assert session.trajectory(to=10).run_status.message == run_status.message
        assert session.diagnose(10).run_status.message == run_status.message
        with session.drive() as drive:
            assert drive.step(10).run_status.message == run_status.message


def test_the_angle_of_an_ensemble_is_that_of_the_member_that_ended_it(client):
    M = np.asarray(scenes.M3) * np.array([0.01, 0.02, 1, 0.03])[:, None, None]
    scene = scenes.rigid_body(members=4, step=5.0, initial={"Q": np.stack([np.eye(3)] * 4), "M": M})
    with client.create(scene) as session, client.create(scenes.left_domain()) as alone:
        together = session.step(to=1).run_status
        assert together.member == 2
        assert angles(together.message) == angles(alone.step(to=1).run_status.message)


def test_in_other_dimensions_there_is_no_angle(client):
    for scene in (scenes.free(4, step=4.0), {**scenes.frame(2, 5), "step": 20.0}):
        with client.create(scene) as session:
            run_status = session.step(to=10).run_status
            assert run_status.outcome is Outcome.LEFT_DOMAIN
            assert "°" not in run_status.message and "the largest |h| that has one here is" in run_status.message
