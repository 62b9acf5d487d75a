"""Ensembles: each member has the bits that its scene has alone."""
import numpy as np
import pytest

import scenes
import stiefel


def ensemble(parts, **changes):
    """Returns the ensemble of the scenes, their blocks stacked as arrays (members, n, N)."""
    blocks = {name: np.stack([np.asarray(part["initial"][name], float) for part in parts])
              for name in parts[0]["initial"]}
    return {**parts[0], "members": len(parts), "initial": blocks,
            "inertia": np.stack([part["inertia"] for part in parts]), **changes}


def spinning(count, method="variational"):
    """Returns different bodies in three dimensions."""
    return [scenes.free(3, seed, method) for seed in range(1, count + 1)]


PARTS = {
    "N = 3": spinning(19),
    "N = 3, rk4": spinning(5, "rk4"),
    "N = 3, exact": spinning(3, "exact"),
    "N = 4": [scenes.free(4, seed) for seed in (1, 2, 3)],
    "V(2, 5)": [scenes.frame(2, 5, seed) for seed in (1, 2)],
}


@pytest.fixture(params=list(PARTS))
def parts(request):
    return PARTS[request.param]


def test_a_stream_has_an_axis_of_members(client, parts):
    with client.create(ensemble(parts)) as together:
        run = together.trajectory(to=7, every=2)
        assert run["Q"].shape == (5, len(parts), *np.shape(parts[0]["initial"]["Q"]))
        np.testing.assert_array_equal(run["Q"][-1], together.step(7)["Q"])


def test_a_fork_starts_where_all_are(client, parts):
    with client.create(ensemble(parts)) as old, old.fork(at=5) as new:
        np.testing.assert_allclose(new.step(0)["Q"], old.step(5)["Q"], atol=1e-14)


def test_many_numbers_travel_as_a_tensor(client):
    parts = spinning(500)
    message = stiefel.to_message(ensemble(parts))
    assert set(message.initial_tensors) == {"Q", "M"} and not message.initial
    with client.create(message) as together, client.create(parts[321]) as alone:
        np.testing.assert_array_equal(together.step(9)["M"][321], alone.step(9)["M"])


def test_the_member_that_stops_is_named(client):
    parts = spinning(3)
    parts[1] = {**parts[1], "initial": {**parts[1]["initial"], "M": 500 * parts[1]["initial"]["M"]}}
    with client.create(ensemble(parts)) as together:
        state = together.step(10)
        assert state.outcome == stiefel.Outcome.LEFT_DOMAIN and state.step == 0
        assert state.run_status.member == 1 and state.run_status.message.startswith("member 1: ")


def test_engineers_may_have_many_bodies(client):
    scene = scenes.body(moments=[1, 2, 3], attitude=None, angular_velocity=[[0.1, 2, 0.1], [1, 0, 0.5]])
    with client.create({**scene, "members": 2}) as together:
        second = scenes.body(attitude=None, angular_velocity=[1, 0, 0.5])
        with client.create(second) as alone:
            np.testing.assert_array_equal(together.step(4, fields=["quaternion"])["quaternion"][1],
                                          alone.step(4, fields=["quaternion"])["quaternion"])


@pytest.mark.parametrize("changes, fault", [
    ({"members": 0}, "members: 0"),
    ({"members": 10**6, "inertia": [1, 2, 3], "initial": {"M": np.zeros((9, 3))}}, "members: 1000000"),
    ({"members": 4, "inertia": [1, 2, 3], "initial": {"M": np.zeros((9, 3))}}, "initial.M: 9 x 3"),
    ({"members": 4}, r"the shape \(3, 3, 3\): must be \(4, rows, cols\), or \(4 rows, cols\)"),
    ({"inertia": [1, 1]}, "must have 3|must be 2 x 2"),
    ({"method": None, "tolerance": 1e-6}, "horizon: absent"),
    ({"initial": {"M": np.zeros((3, 3, 3)), "Q": np.stack([np.eye(3), np.eye(3), np.diag([1, 1, 2])])}}, "member 2"),
], ids=lambda value: None if isinstance(value, str) else "".join(value))
def test_what_is_wrong_is_named(client, changes, fault):
    scene = {name: value for name, value in ensemble(spinning(3), **changes).items() if value is not None}
    with pytest.raises(stiefel.InvalidArgument, match=fault):
        client.create(scene)


def test_the_same_numbers_in_other_members_are_another_scene(client):
    one = scenes.free(3)
    with client.create(one, id="one-or-none"):
        with pytest.raises(stiefel.AlreadyExists):
            client.create({**one, "members": 1}, id="one-or-none")
    four = scenes.frame(4, 6)
    four["initial"]["S"] = np.zeros((4, 6))
    with client.create(four, id="four-or-two"):
        with pytest.raises(stiefel.AlreadyExists):
            client.create({**four, "members": 2}, id="four-or-two")


def test_an_ensemble_is_not_converted(client, parts):
    with pytest.raises(stiefel.InvalidArgument, match=rf"scene.members: {len(parts)}: must be absent: convert the scene of each"):
        client.convert(ensemble(parts), system="velocity")


@pytest.mark.parametrize("change, fault", [
    ({"data_type": 0}, "data_type"), ({"shape": [3]}, "shape"), ({"shape": [3, 4]}, "data"),
    ({"shape": [2**40, 2**40]}, "shape"),
], ids=lambda value: None if isinstance(value, str) else "".join(value))
def test_a_tensor_must_hold_what_it_says(client, change, fault):
    message = stiefel.to_message(scenes.rigid_body(initial={"Q": np.eye(3)}))
    tensor = message.initial_tensors["M"]
    tensor.shape.extend(change.get("shape", [3, 3]))
    tensor.data_type = change.get("data_type", 1)
    tensor.data = np.asarray(scenes.M3, "<f8").tobytes()
    with pytest.raises(stiefel.InvalidArgument, match=f"initial_tensors.M.{fault}"):
        client.create(message)


def test_a_block_is_given_once(client):
    message = stiefel.to_message(scenes.rigid_body())
    message.initial_tensors["M"].CopyFrom(message.initial_tensors["M"])
    with pytest.raises(stiefel.InvalidArgument, match="initial_tensors.M: given"):
        client.create(message)
