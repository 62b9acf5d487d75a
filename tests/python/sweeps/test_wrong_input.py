"""Wrong input: an error with the path and the rule, before work starts."""
import re
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from cases import MOMENTS, SCENE, SPINS, WITHOUT_METHOD, small_chunks, sweep  # noqa: F401

import stiefel

AXES = [
    ({}, "axes: {}: must be a mapping from paths into the scene to values"),
    ({"body.spin": SPINS}, r"axes\['body.spin'\]: body.spin: must be a field that a sweep varies, or one number of a list: inertia, "),
    ({3: [1]}, r"axes\[3\]: must be a path into the scene"),
    ({"body.moments": [1, 2, 3]}, r"axes\['body.moments'\]: the shape \(3,\): must be \(points, 3\)"),
    ({"body.moments": [[1, 2, 3], [1, 2]]}, r"axes\['body.moments'\]: .*: must be numbers, its rows of one length"),
    ({"step": ["fast"]}, r"axes\['step'\]: 'fast': must be numbers of seconds"),
    ({"method.order": [2.5]}, r"axes\['method.order'\]: \[2.5\]: must be whole numbers of at least 0"),
    ({"method": ["rk4", {"nme": "rk4"}]}, r"axes\['method'\]\[1\]: method.nme: unknown field; did you mean name"),
    ({"body.moments": MOMENTS, "body.moments[0]": 60 * [1]}, r"axes\['body.moments'\]: body.moments\[0\] is an axis too"),
    ({"body.moments": MOMENTS, "body.angular_velocity": SPINS[:7]}, r"'body.moments': 60, .*: must have as many values"),
]
OPTIONS = [
    ({"summarize": {}}, "summarize: {}: must be a mapping from fields and invariants"),
    ({"summarize": {"energy": "mode"}}, "quantities.energy.statistics: 'mode': must be one of last, min, max"),
    ({"summarize": {"energy": []}}, r"summarize\['energy'\]: nothing is asked for"),
    ({"summarize": {"energy": {"statistics": "mean", "over_members": True}}}, r"\['energy'\]: over_members: must be absent: reduce the"),
    ({"summarize": {"spin": "last"}}, "spin"),
    ({"to": -1}, "to: -1: must be a whole number of at least 0"),
    ({"executor": 7}, "executor: 7: must have submit"),
    ({"servers": ["localhost:1"], "executor": ThreadPoolExecutor(1)}, "executor: servers are given too"),
    ({"scene": {**SCENE, "members": 3}}, "scene.members: 3: must be absent"),
]


@pytest.mark.parametrize("options, message", [({"axes": axes}, message) for axes, message in AXES] + OPTIONS)
def test_it_is_named(options, message):
    with pytest.raises(stiefel.InvalidArgument, match=message) as caught:
        sweep(**options)
    assert caught.value.violations


def test_an_executor_that_is_shut_down_a_server_that_is_not_there_and_xarray_that_is_not_installed(monkeypatch):
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(RuntimeError, match="cannot schedule new futures after shutdown"):
        sweep(executor=pool)
    monkeypatch.setattr("stiefel._sweep.dispatch.ATTEMPTS", 1)
    with pytest.raises(stiefel.SweepFailed, match="point 0 failed 1 times, at last with LostServer: on .*: cannot reach 127.0.0.1:1"):
        sweep(servers=["127.0.0.1:1"])
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"xarray is needed for this: pip install 'stiefel\[xarray\]'"):
        sweep()


@pytest.mark.parametrize("scene, done", [(SCENE, r"; \d+ of 15 chunks are done"), (WITHOUT_METHOD, "")])
def test_a_point_that_is_no_body_is_found_with_its_place(small_chunks, scene, done):
    """When its chunk is computed, or where the scene names no method when the method is chosen."""
    moments = MOMENTS.copy()
    moments[58] = [1, -2, 3]
    with pytest.raises(stiefel.InvalidArgument, match=rf"scene.body.moments: .*\(member 2\).*chunk of points 56 to 59\){done}") as caught:
        sweep(scene=scene, axes={"body.moments": moments})
    if done:
        outcome = caught.value.partial["outcome"]
        assert (outcome[56:] == 0).all() and (outcome[:40] == 1).all()


def test_impossible_moments_of_points_or_of_the_scene_give_one_warning(small_chunks):
    moments = MOMENTS.copy()
    moments[[21, 22]] = [[1, 1, 6], [1, 2, 8]]
    rule = "no rigid body has these moments; are all three in one unit?"
    with pytest.warns(stiefel.SceneWarning) as caught:
        sweep(axes={"body.moments": moments}, threads=1)
        sweep(scene={**SCENE, "body": {"moments": [1, 1, 5]}}, axes={"body.angular_velocity": SPINS})
    said = [re.fullmatch(rf"point (\d+): (.*): {re.escape(rule)}; others may have a warning like this", str(one.message)).groups() for one in caught]
    assert said == [("21", "I1 + I2 = 2 < I3 = 6"), (said[1][0], "I1 + I2 = 2 < I3 = 5")]
    assert all(one.filename == sweep.__code__.co_filename for one in caught)
