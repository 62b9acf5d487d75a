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


def test_eight_clients_at_once(client, session, expected):
    def reach(worker):
        mine = client.get(session.id)
        for k in range(worker * 31, K, 400):
            mine.step(to=k)
        return bits(mine.step(to=K))

    with ThreadPoolExecutor(8) as pool:
        assert all(found == expected for found in pool.map(reach, range(8)))


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
