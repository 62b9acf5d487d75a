"""The state at step k has the same bits however it was reached."""
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import scenes

K = 2000  # the step that the tests reach in different ways


def bits(state):
    return {name: values.tobytes() for name, values in state.fields.items()}


@pytest.fixture(scope="module", params=scenes.BIT_SCENES)
def scene(request):
    return scenes.BIT_SCENES[request.param]


@pytest.fixture(scope="module")
def expected(client, scene):
    with client.create(scene) as session:
        state = session.step(to=K)
        assert state.outcome == "REACHED" and state.step == K and state.computed_steps == K
        assert all(np.isfinite(values).all() for values in state.fields.values())
        return bits(state)


@pytest.fixture
def session(client, scene):
    with client.create(scene) as session:
        yield session


def test_many_steps(session, expected):
    for k in range(0, K, 40):
        session.step(to=k)
    assert bits(session.step(to=K)) == expected


def test_stream(session, expected):
    run = session.trajectory(to=K, every=7)
    assert {name: values[-1].tobytes() for name, values in run.fields.items()} == expected


def test_drive(session, expected):
    with session.drive() as drive:
        for k in range(0, K, 20):
            drive.step(k)
        assert bits(drive.step(K)) == expected


def test_past_it_and_back(session, expected):
    session.step(to=3 * K + 17)
    assert bits(session.step(to=K)) == expected


def test_from_its_middle(session, expected):
    """A stream may start at k while the cursor is elsewhere."""
    session.step(to=K // 3)
    run = session.trajectory(start=K, to=K + 3)
    assert {name: values[0].tobytes() for name, values in run.fields.items()} == expected


def test_eight_clients_at_once(client, session, expected):
    def reach(worker):
        mine = client.get(session.id)
        for k in range(worker * 31, K, 400):
            mine.step(to=k)
        return bits(mine.step(to=K))

    with ThreadPoolExecutor(8) as pool:
        assert all(found == expected for found in pool.map(reach, range(8)))


def test_resolved_scene_is_the_same_motion(client, session, expected):
    with client.create(session._resolved()) as again:
        assert again._resolved() == session._resolved()
        assert bits(again.step(to=K)) == expected


def test_second_server_from_the_scene(other, scene, expected):
    with other.create(scene) as session:
        assert bits(session.step(to=K)) == expected


def test_second_server_from_a_checkpoint(session, other, scene, expected):
    half = session.step(to=K // 2, checkpoint=True)
    assert half.checkpoint
    with other.create(scene, checkpoint=half.checkpoint) as there:
        reached = there.step(to=K)
        assert reached.computed_steps == K - K // 2
        assert bits(reached) == expected


def test_a_closed_form_goes_anywhere_at_once(client, other):
    far, scene = 10**15, scenes.rigid_body(method={"name": "exact"})
    with client.create(scene) as session, other.create(scene) as there:
        state = session.step(to=far)
        assert state.outcome == "REACHED" and state.step == far and state.computed_steps == 1
        assert session.step(to=0).computed_steps == 0
        assert bits(session.step(to=far)) == bits(state)
        run = there.trajectory(to=far, every=far // 7)
        assert {name: values[-1].tobytes() for name, values in run.fields.items()} == bits(state)


def test_ten_thousand_single_steps(client):
    with client.create(scenes.rigid_body()) as session, session.drive() as drive:
        driven = [drive.step(k) for k in range(1, 10_001)][-1]
    with client.create(scenes.rigid_body()) as session:
        assert bits(session.step(to=10_000)) == bits(driven)
