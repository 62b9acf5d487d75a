"""A session is a pure function from step index to state: the state does not depend on the calls before."""
import numpy as np
from hypothesis import given, strategies as st

import scenes
import stiefel

LAST = 200
LARGEST_REPAIR = 1e-2


def bits(fields, index=...):
    return {name: np.asarray(values[index]).tobytes() for name, values in fields.items()}


def walk_step(client, session, k):
    return bits(session.step(to=k).fields)


def walk_stream(client, session, k):
    return bits(session.trajectory(to=k, every=7).fields, -1)


def walk_from_there(client, session, k):
    return bits(session.trajectory(start=k, to=k + 3).fields, 0)


def walk_drive(client, session, k):
    with session.drive() as drive:
        drive.step(k // 3)
        return bits(drive.step(k).fields)


def walk_checkpoint(client, session, k):
    """Goes to step k in another session, which starts from a checkpoint of this one."""
    checkpoint = session.step(to=k // 2, checkpoint=True).checkpoint
    with client.create(session._resolved(), checkpoint=checkpoint) as other:
        return bits(other.step(to=k).fields)


def walk_resolved(client, session, k):
    with client.create(session._resolved()) as other:
        return bits(other.step(to=k).fields)


WALKS = [walk_step, walk_stream, walk_from_there, walk_drive, walk_checkpoint, walk_resolved]


@given(data=st.data())
def test_the_state_at_k_is_one(client, pair, data):
    scene = data.draw(scenes.scenes(pair))
    path = data.draw(st.lists(st.tuples(st.sampled_from(WALKS), st.integers(0, LAST)), min_size=2, max_size=6))
    with client.create(scene) as session:
        session.step(to=LAST)
        states = dict(zip(range(LAST + 1), session.trajectory(to=LAST)[scenes.first_block(session.scene)]))
        for walk, k in path:
            reached = walk(client, session, k)
            assert next(iter(reached.values())) != b""
            with client.create(scene) as fresh:
                assert reached == bits(fresh.step(to=k).fields), (walk.__name__, k)
            assert reached[scenes.first_block(session.scene)] == states[k].tobytes()


@given(data=st.data())
def test_to_ask_twice_changes_nothing(client, pair, data):
    scene, k = data.draw(scenes.scenes(pair)), data.draw(st.integers(0, LAST))
    with client.create(scene, id="twice") as session:
        state = bits(session.step(to=k).fields)
        again = client.create(scene, id="twice")
        assert not again.created and again._resolved() == session._resolved()
        assert bits(again.step(to=k).fields) == state
        assert session.diagnose(to=k) == quiet(session.diagnose(to=k), session.diagnose(to=k))
        session.delete()
    client.delete("twice")


def quiet(first, second):
    """Asserts that both are equal, and returns the first."""
    assert first == second
    return first


@given(data=st.data())
def test_a_resolved_scene_resolves_to_itself(client, pair, data):
    with client.create(data.draw(scenes.scenes(pair))) as session, client.create(session._resolved()) as again:
        assert again._resolved() == session._resolved()


@given(data=st.data())
def test_a_fork_goes_on_as_the_old_one_would(client, pair, data):
    """A fork starts from the same blocks, repaired if they have drifted, and without the solver's history, so that its
    motion is the same up to rounding and drift."""
    scene, k, on = data.draw(scenes.scenes(pair)), data.draw(st.integers(0, 40)), data.draw(st.integers(0, 20))
    with client.create(scene) as session:
        here, drift = session.step(to=k), session.diagnose(to=k).orthogonality or 0.0
        try:
            fork = session.fork(at=k)
        except stiefel.InvalidArgument as refused:
            assert drift > LARGEST_REPAIR / 10 and "to 0.01" in str(refused)
            return
        with fork:
            off, there = 1e3 * scenes.unit(scene) + 10 * drift, fork.step(to=0)
            for name in session.scene["initial"].keys() & here.fields.keys():
                np.testing.assert_allclose(there[name], here[name], rtol=0, atol=off)
            far, near = session.step(to=k + on), fork.step(to=on)
            for name in far.fields:
                np.testing.assert_allclose(near[name], far[name], rtol=0, atol=100 * off)
