"""The resolved scene is what was sent with what the reply fills in."""
import numpy as np
import pytest

import stiefel
from stiefel import v1 as pb
from stiefel._wire.resolved import put, resolve, with_blocks_as_matrices


def matrix(*values):
    return pb.Matrix(rows=1, cols=len(values), values=values)


SENT = pb.Scene(system="rigid_body", inertia=[3, 2, 1], step=0.5, tolerance=1e-6, horizon=2.0,
                body=pb.Body(moments=[1, 2, 3], angular_velocity=[1, 0, 0]), initial={"M": matrix(1, 2)})


def test_a_field_that_is_filled_in_takes_the_place_of_the_one_sent():
    scene = resolve(SENT, pb.Scene(inertia=[9], method=pb.Method(name="rk4", order=4)), ["tolerance"])
    assert list(scene.inertia) == [9] and scene.method.name == "rk4"
    assert not scene.HasField("tolerance") and scene.horizon == 2.0 and scene.step == 0.5
    assert SENT.HasField("tolerance") and list(SENT.inertia) == [3, 2, 1]  # what was sent stays


def test_of_the_body_each_field_stands_for_itself():
    scene = resolve(SENT, pb.Scene(body=pb.Body(attitude=[1, 0, 0, 0], moments=[4, 5, 6])), [])
    assert scene.body == pb.Body(moments=[4, 5, 6], attitude=[1, 0, 0, 0], angular_velocity=[1, 0, 0])
    assert not resolve(SENT, pb.Scene(), ["body"]).HasField("body")


def test_blocks_are_replaced_all_together():
    sent = pb.Scene()
    sent.CopyFrom(SENT)
    sent.initial_tensors["Q"].CopyFrom(pb.Tensor(shape=[1, 2], data_type=pb.DATA_TYPE_FLOAT64, data=bytes(16)))
    assert set(resolve(sent, pb.Scene(step=1.0), []).initial_tensors) == {"Q"}
    scene = resolve(sent, pb.Scene(initial={"P": matrix(7)}), [])
    assert dict(scene.initial) == {"P": matrix(7)} and not scene.initial_tensors
    for left_out in (["initial.P"], []):
        scene = resolve(sent, pb.Scene(), [] if left_out else ["initial"], left_out)
        assert not scene.initial and not scene.initial_tensors


def test_arrays_that_come_for_themselves_are_put_in():
    scene = resolve(SENT, pb.Scene(), [], ["initial.Q"])
    put({"initial.Q": np.array([[[1.0, 2j]], [[3, 4]]]), "inertia": np.array([[5.0, 6]]),
         "body.attitude": np.array([[1.0, 0, 0, 0]])}, scene)
    assert dict(scene.initial) == {"Q": pb.Matrix(rows=2, cols=2, values=[1, 0, 3, 4], imaginary=[0, 2, 0, 0])}
    assert list(scene.inertia) == [5, 6] and list(scene.body.attitude) == [1, 0, 0, 0]
    with pytest.raises(stiefel.CorruptReply, match="a scene has no array mass"):
        put({"mass": np.ones((1, 1))}, scene)


def test_blocks_sent_as_tensors_are_read_as_matrices():
    M = np.arange(9.0 * 500).reshape(-1, 9)
    scene = stiefel.to_message({"system": "rigid_body", "initial": {"M": M}})
    assert set(scene.initial_tensors) == {"M"}
    found = with_blocks_as_matrices(scene)
    assert not found.initial_tensors and found.initial["M"].rows == 500
    assert list(found.initial["M"].values) == M.ravel().tolist()
