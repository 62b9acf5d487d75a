"""A scene that names neither a method nor a tolerance gets the recommended one."""
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
        method = session._resolved().method
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


def test_a_horizon_alone_is_no_choice(client):
    with client.create({**without_method(scenes.rigid_body()), "horizon": 5.0}) as session:
        assert session.scene["method"]["name"] == "exact" and session.scene["horizon"] == 5.0
