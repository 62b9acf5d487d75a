"""A scene that names neither a method nor a tolerance gets the recommended one."""
import numpy as np
import pytest

import scenes


def without_method(scene):
    return {name: value for name, value in scene.items() if name != "method"}


def recommended(client, system):
    listed = {info.name: info for info in client.describe().systems}
    return listed[system].recommended


@pytest.mark.parametrize("scene", [
    scenes.rigid_body(), scenes.rigid_body(initial={"M": scenes.M3}), scenes.body(), scenes.free(4), scenes.free(6),
    scenes.frame(1, 3), scenes.frame(2, 5), scenes.frame(3, 3),
], ids=["N = 3", "momentum only", "body", "N = 4", "N = 6", "sphere", "V(2, 5)", "n = N"])
def test_the_resolved_scene_has_one_that_describe_lists(client, scene):
    with client.create(without_method(scene)) as session:
        method = session.resolved().method
        assert any(one.method.name == method.name and one.method.order == method.order
                   and one.method.tolerance == method.tolerance and one.method.arithmetic == method.arithmetic
                   for one in recommended(client, scene["system"]))
        assert method.HasField("substeps") and method.scalar == "double"
        assert session.choice is None
        for same in (without_method(scene), session.scene):
            assert not client.create(same, id=session.id).created
        with client.create(session.scene) as again:
            assert again.scene == session.scene
            now, then = again.step(30), session.step(30)
            assert {name: now[name].tobytes() for name in now} == {name: then[name].tobytes() for name in then}


def test_every_continuous_system_has_one_and_no_discrete_one(client):
    for system in client.describe().systems:
        assert bool(system.recommended) != system.discrete
        if not system.discrete:
            assert not system.recommended[-1].where
            assert {one.method.name for one in system.recommended} <= {on.method for on in system.methods}


@pytest.mark.parametrize("step", [0.05, -0.3, 2.0])
def test_it_is_accurate_whatever_the_step(client, step):
    """Compares a hundred rotations of an ensemble's top with the closed form."""
    exact = {**scenes.free(3, step=step / 2), "method": {"name": "exact"}}  # |Omega| = 2
    scene = {**exact, "members": 1}
    steps = round(200 * np.pi / abs(step))
    with client.create(without_method(scene)) as session, client.create(exact) as top:
        now, then = session.step(steps), top.step(steps)
        substeps = session.resolved().method.substeps
    for name in ("Q", "M"):
        np.testing.assert_allclose(now[name][0], then[name], atol=1e-8 * abs(then[name]).max())
    assert (substeps > 1) == (abs(step) > 0.25)


def test_a_fork_to_a_system_without_its_method_takes_the_recommended_one(client):
    with client.create(scenes.free(3, method="preprocessed_variational")) as top:
        with top.fork(at=5, system="right_rigid_body") as right:
            assert right.scene["method"]["name"] == recommended(client, "right_rigid_body")[0].method.name
            for name in ("M",):
                np.testing.assert_allclose(-right.step(0)[name], top.step(5)[name], atol=1e-13)


def test_members_of_an_ensemble_take_one_for_all(client):
    scene = without_method(scenes.rigid_body(
        members=2, initial={"Q": np.stack([np.eye(3)] * 2), "M": np.asarray(scenes.M3) * np.array([1, 60])[:, None, None]}))
    alone = without_method(scenes.rigid_body(
        members=1, initial={"Q": np.eye(3)[None], "M": 60 * np.asarray(scenes.M3)[None]}))
    with client.create(scene) as both, client.create(alone) as fast:
        assert both.scene["method"] == fast.scene["method"]
        assert both.scene["method"]["substeps"] > 1
        assert both.step(20)["M"][1].tobytes() == fast.step(20)["M"][0].tobytes()


def test_a_horizon_alone_is_no_choice(client):
    with client.create({**without_method(scenes.rigid_body()), "horizon": 5.0}) as session:
        assert session.scene["method"]["name"] == "exact" and session.scene["horizon"] == 5.0
