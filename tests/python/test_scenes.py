import json

import numpy as np
import pytest

import stiefel
from stiefel.v1 import scene_pb2

SCENE = {
    "system": "rigid_body",
    "method": {"name": "variational", "order": 2},
    "inertia": [2.5, 1.5, 0.5],
    "initial": {"M": {"rows": 3, "cols": 3, "values": [0, -0.01, 3, 0.01, 0, -0.001, -3, 0.001, 0]}},
    "step": 0.01,
}
M = np.array(SCENE["initial"]["M"]["values"]).reshape(3, 3)


def test_a_dict_a_file_and_a_message_are_the_same_scene(tmp_path):
    message = stiefel.to_message(SCENE)
    assert message.method.order == 2 and list(message.initial["M"].values) == list(M.ravel())
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(SCENE))
    assert stiefel.to_message(file) == stiefel.to_message(str(file)) == stiefel.to_message(message) == message


def test_arrays_and_numpy_numbers_may_stand_in_a_dict():
    scene = {**SCENE, "inertia": np.array([2.5, 1.5, 0.5]), "initial": {"M": M}, "step": np.float64(0.01)}
    assert stiefel.to_message(scene) == stiefel.to_message(SCENE)
    assert stiefel.to_message({**scene, "initial": {"M": M.tolist()}}) == stiefel.to_message(SCENE)


def test_the_json_form_reads_back_the_same():
    message = stiefel.to_message(SCENE)
    assert stiefel.to_message(json.loads(json.dumps(stiefel.to_dict(message)))) == message


@pytest.mark.parametrize("scene, word", [
    ({**SCENE, "steps": 3}, "steps"),
    ({**SCENE, "method": {"nmae": "rk4"}}, "nmae"),
    ({**SCENE, "step": "soon"}, "step"),
    ({**SCENE, "inertia": "heavy"}, "inertia"),
])
def test_unknown_fields_and_wrong_types_are_errors(scene, word):
    with pytest.raises(stiefel.InvalidArgument, match=word) as caught:
        stiefel.to_message(scene)
    assert caught.value.violations[0].field == "scene"


def test_a_scene_is_not_changed_by_reading_it():
    scene = {**SCENE, "initial": {"M": M}}
    assert isinstance(stiefel.to_message(scene), scene_pb2.Scene)
    assert scene["initial"]["M"] is M
