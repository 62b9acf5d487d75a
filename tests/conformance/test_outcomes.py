"""A numerical stop is an outcome with the last good state, never an error."""
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
    assert 0 < state.ending.largest_step < 5
    assert state.ending.message


def test_the_largest_step_works_and_a_little_more_does_not(client, session):
    largest = session.step(to=1).ending.largest_step
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
    assert diagnosis.ending.largest_step > 0


def test_a_motion_that_overflows(client):
    """rk4 far outside its stability: the numbers grow until they are none."""
    with client.create(scenes.rigid_body(method={"name": "rk4"}, step=40.0)) as session:
        state = session.step(to=100_000)
        assert state.outcome is Outcome.NOT_FINITE
        assert 0 <= state.step < 100_000
        assert session.step(to=state.step).outcome is Outcome.REACHED
