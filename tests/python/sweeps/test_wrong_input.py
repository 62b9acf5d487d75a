"""Wrong input: an error with the path and the rule, before work starts."""
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from cases import MOMENTS, SCENE, SPINS, plain_result, processes, small_chunks, sweep  # noqa: F401

import stiefel


@pytest.mark.parametrize("axes, message", [
    ({}, "axes: {}: must be a mapping from paths into the scene to values"),
    ({"body.spin": SPINS}, r"axes\['body.spin'\]: body.spin: must be a field that a sweep varies: inertia, "),
    ({"initial.": SPINS}, r"axes\['initial.'\]: initial.: must be a field that a sweep varies"),
    ({"members": [1, 2]}, r"axes\['members'\]: members: must be a field that a sweep varies"),
    ({3: [1]}, r"axes\[3\]: must be a path into the scene"),
    ({"body.moments": [1, 2, 3]}, r"axes\['body.moments'\]: the shape \(3,\): must be \(points, 3\)"),
    ({"body.moments": MOMENTS[:, :2]}, r"axes\['body.moments'\]: the shape \(60, 2\): must be \(points, 3\)"),
    ({"body.moments": np.empty((0, 3))}, r"axes\['body.moments'\]: the shape \(0, 3\): must be"),
    ({"body.moments": [[1, 2, 3], [1, 2]]}, r"axes\['body.moments'\]: .*: must be numbers, its rows of one length"),
    ({"body.moments": [["a", "b", "c"]]}, r"axes\['body.moments'\]: .*: must be numbers"),
    ({"step": [[0.1]]}, r"axes\['step'\]: the shape \(1, 1\): must be \(points\)"),
    ({"step": ["fast"]}, r"axes\['step'\]: 'fast': must be numbers of seconds"),
    ({"method.name": [1, 2]}, r"axes\['method.name'\]: \[1, 2\]: must be names"),
    ({"method.order": [2.5]}, r"axes\['method.order'\]: \[2.5\]: must be whole numbers of at least 0"),
    ({"method.order": [-2]}, r"axes\['method.order'\]: \[-2\]: must be whole numbers of at least 0"),
    ({"initial.Q": np.eye(3)[0]}, r"axes\['initial.Q'\]: the shape \(3,\): must be \(points, rows, cols\)"),
    ({"body.moments[0,1]": [1]}, r"axes\['body.moments\[0,1\]'\]: .*: must have 1 indices, or none"),
    ({"body.moments[3]": [1]}, r"the scene's body.moments has the shape \(3,\): must have this entry"),
    ({"initial.Q[0,0]": [1]}, r"the scene's initial.Q is absent: must have this entry"),
    ({"body.moments": MOMENTS, "body.moments[0]": [1]}, "body.moments.* is an axis too"),
    ({"body.moments": MOMENTS, "body.angular_velocity": SPINS[:7]}, r"'body.moments': 60, .*: must have as many values"),
])
def test_axes(axes, message):
    with pytest.raises(stiefel.InvalidArgument, match=message) as caught:
        sweep(axes=axes)
    assert caught.value.violations


def test_all_wrong_axes_are_named():
    with pytest.raises(stiefel.InvalidArgument) as caught:
        sweep(axes={"body.spin": [1], "step": [[1]]})
    assert [violation.field for violation in caught.value.violations] == ["axes['body.spin']", "axes['step']"]


@pytest.mark.parametrize("options, message", [
    ({"summarize": {}}, "summarize: {}: must be a mapping from fields and invariants"),
    ({"summarize": {"energy": "mode"}}, "quantities.energy.statistics: 'mode': must be one of last, min, max"),
    ({"summarize": {"energy": []}}, r"summarize\['energy'\]: nothing is asked for"),
    ({"summarize": {"energy": {"median": 1}}}, "quantities.energy.median: unknown field; the fields are name, statistics, quantiles"),
    ({"summarize": {"energy": {"statistics": ["mean", "last"], "over_members": True}}}, r"\['energy'\]: over_members: last does not"),
    ({"summarize": {"energy": {"quantiles": [0.5], "over_members": True}}}, "over_members: quantiles does not follow"),
    ({"summarize": {"spin": "last"}}, "spin"),
    ({"to": -1}, "to: -1: must be a whole number of at least 0"),
    ({"to": 1.5}, "to: 1.5: must be a whole number"),
    ({"every": 0}, "every: 0: must be a whole number of at least 1"),
    ({"executor": 7}, "executor: 7: must be an executor of concurrent.futures"),
    ({"executor": lambda: 7}, "executor: 7: must have submit"),
    ({"servers": []}, r"servers: \[\]: must be a list of addresses or clients"),
    ({"servers": "localhost:1"}, "servers: 'localhost:1': must be a list of addresses"),
    ({"servers": ["localhost:1"], "executor": lambda: None}, "executor: servers are given too"),
    ({"scene": {**SCENE, "members": 3}}, "scene.members: 3: must be absent"),
    ({"scene": {**SCENE, "sytem": 3}}, "scene.sytem: unknown field"),
    ({"scene": {**SCENE, "method": {"name": "verlet"}}}, 'scene.method.name: "verlet": must be one of'),
])
def test_options(options, message):
    with pytest.raises(stiefel.InvalidArgument, match=message):
        sweep(**options)


def test_an_executor_that_is_shut_down():
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(RuntimeError, match="cannot schedule new futures after shutdown"):
        sweep(executor=pool)


def test_a_server_that_is_not_there(monkeypatch):
    monkeypatch.setattr("stiefel._sweep.failures.ATTEMPTS", 1)
    with pytest.raises(stiefel.SweepFailed, match="no worker answered: LostServer: localhost:1.*cannot reach"):
        sweep(servers=["localhost:1"])


def test_a_point_that_is_no_body_is_found_with_its_place(monkeypatch):
    """The server finds it when the chunk comes, and says which."""
    monkeypatch.setattr("stiefel._sweep.chunks.LARGEST", 4)
    moments = MOMENTS.copy()
    moments[30] = [1, -2, 3]
    with pytest.raises(stiefel.InvalidArgument, match=r"scene.body.moments: .*\(member 2\).*chunk of points 28 to 31"):
        sweep(axes={"body.moments": moments})


@pytest.mark.parametrize("on", ["cores", "processes", "store"])
def test_what_is_done_is_kept_when_a_late_point_is_wrong(small_chunks, plain_result, tmp_path, on):
    moments = MOMENTS.copy()
    moments[58] = [1, -2, 3]
    options = {"executor": lambda: processes(1)} if on == "processes" else {}
    if on == "store":
        pytest.importorskip("zarr")
        options["store"] = tmp_path / "store"
    with pytest.raises(stiefel.InvalidArgument, match=r"chunk of points 56 to 59\); 14 of 15 chunks are done") as caught:
        sweep(axes={"body.moments": moments}, **options)
    partial, whole = caught.value.partial, sweep(axes={"body.moments": MOMENTS})
    assert partial["outcome"].tolist() == [1] * 56 + [0] * 4
    assert (partial["energy.drift"][:56] == whole["energy.drift"][:56]).all() and np.isnan(partial["energy.drift"][56:]).all()
    assert ("they are in the store" in str(caught.value)) == (on == "store") and "member 2" in str(caught.value)


def fail(task):
    raise RuntimeError("on purpose")


class FailsAtTheEnd(ThreadPoolExecutor):
    def submit(self, function, task):
        return super().submit(fail if getattr(task, "index", 0) == 14 else function, task)


def test_what_is_done_is_kept_when_a_task_raises_what_nobody_knows(small_chunks, plain_result):
    with FailsAtTheEnd(1) as executor, pytest.raises(RuntimeError, match="on purpose") as caught:
        sweep(executor=executor)
    assert caught.value.partial["outcome"].tolist() == [1] * 56 + [0] * 4


@pytest.mark.parametrize("on", ["cores", "processes", "store"])
def test_impossible_moments_of_any_point_give_a_warning(small_chunks, plain_result, tmp_path, on):
    options = {} if on == "cores" else {"executor": lambda: processes(2)}
    if on == "store":
        pytest.importorskip("zarr")
        options["store"] = tmp_path / "store"
    moments = MOMENTS.copy()
    moments[[7, 21, 22]] = [[1, 1, 5], [1, 1, 6], [1, 2, 8]]
    with pytest.warns(stiefel.SceneWarning) as caught:
        sweep(axes={"body.moments": moments}, **options)
    assert [str(one.message) for one in caught] == [
        "point 7: I1 + I2 = 2 < I3 = 5: no rigid body has these moments; are all three in one unit? (3 points have a warning like this)"]


def test_a_warning_about_all_points_comes_once(small_chunks):
    scene = {**SCENE, "body": {"moments": [1, 1, 5]}}
    with pytest.warns(stiefel.SceneWarning) as caught:
        sweep(scene=scene, axes={"body.angular_velocity": SPINS})
    assert [str(one.message) for one in caught] == ["I1 + I2 = 2 < I3 = 5: no rigid body has these moments; are all three in one unit?"]
