"""ForkSession: a new session that starts from the state of another one."""
import numpy as np
import pytest

import scenes
import stiefel


def test_a_body_stays_a_body(client):
    with client.create(scenes.body()) as old, old.fork(at=70) as new:
        assert "body" in new.scene
        np.testing.assert_allclose(new.step(0, fields=["quaternion"])["quaternion"],
                                   old.step(70, fields=["quaternion"])["quaternion"], atol=1e-15)


HALVES, RATES = [0.5, -0.5, 0.5, 0.5], [0.3, -0.2, 0.7]
TENSOR = [2.5, 1.9, 3.1, 0.2, -0.1, 0.3]
TURNED = {"Q": [[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]], "M": [[0, -0.3, 0.7], [0.3, 0, -0.1], [-0.7, 0.1, 0]]}
FREE = scenes.free(4)

#: Every way in which a scene gives a motion.
GIVEN = {
    "moments": {"body": {"moments": [1.7, 2.9, 3.1], "angular_velocity": RATES}},
    "attitude": {"body": {"moments": [1.7, 2.9, 3.1], "angular_velocity": RATES, "attitude": [0.6, 0, 0.8, 0]}},
    "tensor": {"body": {"inertia_tensor": TENSOR, "angular_velocity": RATES}},
    "tensor and attitude": {"body": {"inertia_tensor": TENSOR, "angular_velocity": RATES, "attitude": HALVES}},
    "spin": {"body": {"moments": [1.7, 2.9, 3.1], "angular_velocity": [0, 0, 0.3]}},
    "members": {"members": 2, "body": {"moments": [1.7, 2.9, 3.1], "angular_velocity": [*RATES, 0.1, 0.2, -0.3],
                                       "attitude": [*HALVES, 0.6, 0, 0.8, 0]}},
    "blocks": {"inertia": [2.5, 1.5, 0.5], "initial": TURNED},
    "momentum": {"inertia": [2.5, 1.5, 0.5], "initial": {"M": TURNED["M"]}},
    "four axes": {"inertia": FREE["inertia"], "initial": FREE["initial"]},
    "symmetric": {"system": "symmetric_rigid_body", "inertia": [2.5, 1.5, 0.5], "initial": TURNED},
}


def of(name, **changes):
    return {"system": "rigid_body", "step": 0.1, **GIVEN[name], **changes}


def bits(session, steps):
    """Returns the fields of states at steps as bytes."""
    fields = ["quaternion", "angular_velocity", "Q", "M"] if "body" in session.scene else []
    return [{name: value.tobytes() for name, value in session.step(k, fields=fields).fields.items()} for k in steps]


@pytest.mark.parametrize("name", GIVEN)
def test_a_fork_of_step_0_is_the_scene_with_the_changes(client, name):
    with client.create(of(name)) as old:
        old.step(7)
        for changes in ({}, {"step": -0.1}, {"step": 0.05}, {"method": {"name": "munthe_kaas4", "substeps": 3}}):
            method = changes.get("method", old.scene["method"])
            with old.fork(at=0, **changes) as fork, client.create(of(name, **{**changes, "method": method})) as new:
                assert fork._resolved() == new._resolved()
                assert bits(fork, (0, 1, 40, 10_000)) == bits(new, (0, 1, 40, 10_000))


@pytest.mark.parametrize("name", GIVEN)
def test_negative_times_have_the_bits_of_a_negative_step(client, name):
    steps = (1, 40, 10_000)
    with client.create(of(name)) as old, client.create(of(name, step=-0.1, method=old.scene["method"])) as back:
        found = old.trajectory(times=[-0.1 * k for k in steps])
        for i, k in enumerate(steps):
            state = back.step(k)
            for field in state.fields:
                assert found[field][i].tobytes() == state[field].tobytes()


@pytest.mark.parametrize("name", GIVEN)
def test_a_fork_holds_the_numbers_of_the_state(client, name):
    with client.create(of(name)) as old, old.fork(at=50, step=-0.1) as new:
        resolved, state = new._resolved(), old.step(50, fields=["quaternion", "angular_velocity"] if "body" in old.scene else [])
        if "body" in old.scene:
            given = {"quaternion": resolved.body.attitude, "angular_velocity": resolved.body.angular_velocity}
        else:
            given = {block: matrix.values for block, matrix in resolved.initial.items()}
        assert given and {block: list(values) for block, values in given.items()} \
            == {block: state[block].ravel().tolist() for block in given}


def test_a_fork_of_a_drifted_state_may_have_another_step(client):
    scene = of("four axes", step=0.2, method={"name": "rk4"})
    with client.create(scene) as old, old.fork(at=100, step=-0.1) as new, new.fork(at=0, step=0.05) as again:
        Q = old.step(100)["Q"]
        assert 1e-6 < abs(Q @ Q.T - np.eye(4)).max() < 1e-2
        assert again.step(0)["Q"].tobytes() == new.step(0)["Q"].tobytes()
        np.testing.assert_allclose(again.step(0)["Q"], Q, atol=1e-2)


def test_so_does_the_system(client):
    with client.create(scenes.free(4)) as old, old.fork(at=10, system="symmetric_rigid_body") as new:
        assert new.scene["system"] == "symmetric_rigid_body"
        np.testing.assert_allclose(new.step(0, fields=["M"])["M"], old.step(10)["M"], atol=1e-14)


def test_forking_twice_is_the_existing_session(client):
    with client.create(scenes.free(4)) as old:
        with old.fork(at=10, id="fork-of-one") as one:
            assert one.created and not old.fork(at=10, id="fork-of-one").created
            with pytest.raises(stiefel.AlreadyExists):
                old.fork(at=11, id="fork-of-one")


def test_a_step_that_cannot_be_reached_makes_no_session(client):
    with client.create(scenes.left_domain()) as old:
        with pytest.raises(stiefel.FailedPrecondition, match="no solution"):
            old.fork(at=10, id="fork-of-nothing")
    with pytest.raises(stiefel.NotFound):
        client.get("fork-of-nothing")


@pytest.mark.parametrize("change, fault", [
    ({"at": -1}, "at: -1"), ({"step": 0.0}, "step: 0"), ({"method": {"name": "none"}}, 'method.name: "none"'),
    ({"system": "none"}, "system: none: must be a system"), ({"system": "velocity"}, "system: velocity"), ({"id": "a b"}, "session_id: a b"),
], ids=lambda value: None if isinstance(value, str) else "".join(value))
def test_a_wrong_change_names_the_field(client, change, fault):
    with client.create(scenes.free(4)) as old:
        with pytest.raises(stiefel.InvalidArgument, match=fault):
            old.fork(**{"at": 1, **change})


def test_of_an_unknown_session(client):
    session = client.create(scenes.free(4))
    by_id = client.get(session.id)
    session.delete()
    with pytest.raises(stiefel.NotFound, match=f"from_session_id: {session.id}"):
        by_id.fork(at=1)
    with pytest.raises(stiefel.NotFound, match=session.id):
        session.fork(at=1)


def test_a_frame_that_drifted_and_what_hangs_on_it(client):
    """rk4 leaves the group: Q is then not orthogonal and Q^T B not skew, and both are repaired."""
    scene = client.convert(scenes.free(4, method="rk4"), system="mclachlan_scovel").scene
    with client.create(scene) as old:
        assert 1e-12 < old.diagnose(to=200).orthogonality < 1e-6
        with old.fork(at=200) as new:
            assert new.diagnose(to=0).orthogonality < 1e-14
            np.testing.assert_allclose(new.step(to=0)["B"], old.step(to=200)["B"], atol=1e-6)


def test_a_fault_of_what_a_fork_inherits_is_that_of_its_origin(client):
    with client.create(scenes.rigid_body(initial={"M": scenes.M3})) as old:
        with pytest.raises(stiefel.InvalidArgument, match="from_session_id: initial.Q: absent"):
            old.fork(at=0, system="symmetric_rigid_body")
