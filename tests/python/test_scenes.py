import json

import numpy as np
import pytest

import stiefel

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
    message = stiefel.to_message(SCENE)
    assert stiefel.to_message(scene) == stiefel.to_message({**scene, "initial": {"M": M.tolist()}}) == message
    assert scene["initial"]["M"] is M and stiefel.to_message(json.loads(json.dumps(stiefel.to_dict(message)))) == message


BODY = {"moments": [1, 2, 3]}


@pytest.mark.parametrize("scene, path, description", [
    ({**SCENE, "method": {"nmae": "rk4"}}, "scene.method.nmae", "unknown field; did you mean name? The fields are "),
    ({"initial": {"M": {"rows": 1, "colums": 1}}}, "scene.initial.M.colums",
     "unknown field; did you mean cols? The fields are "),
    ({**SCENE, "inertia_tensr": [1, 2]}, "scene.inertia_tensr",
     "unknown field; did you mean body.inertia_tensor? The fields are "),
    ({**SCENE, "step": "soon"}, "scene.step", "'soon': must be a number"),
    ({**SCENE, "inertia": [[1, 2], [3]]}, "scene.inertia", "[[1, 2], [3]]: must be numbers"),
    ({**SCENE, "members": 2**32}, "scene.members", "4294967296: must be a whole number of at least 0 and below 2^32"),
    ({**SCENE, 3: 4}, "scene.3", "unknown field; the fields are system, method, "),
    ({**SCENE, "method": 3}, "scene.method", "3: must be a name, or a mapping with the fields name, order, substeps, arithmetic, tolerance, scalar"),
    ({**SCENE, "torque": [0, 0, 1]}, "scene.torque", "unknown field; there are no torques and no forces: the motion is free (docs/conventions.md). It is [0, 0, 1]"),
    ({"body": {**BODY, "mass": 3}}, "scene.body.mass", "unknown field; the fields are inertia_tensor, moments, attitude, angular_velocity, "
     "order, mrp, euler_angles, sequence, angular_momentum, frame, euler_rates. It is 3"),
    ({**SCENE, "normalize": "x" * 1000}, "scene.normalize", f"'{'x' * 96}...: must be true or false"),
    ({**SCENE, "step": [1, 2]}, "scene.step", "[1, 2]: must be one number"),
    ({"body": {**BODY, "omega": [1, 2, 3]}}, "scene.body.omega", "unknown field; did you mean angular_velocity? The fields are "),
    ({"system": "rigid_body", "dt": 3}, "scene.dt", "unknown field; did you mean step? The fields are "),
    ({**SCENE, "body": {"system": "rigid_body", "body": BODY}}, "scene.body", "is a whole scene, as stiefel.body_scene returns it"),
    ({**SCENE, "method": ["rk4"]}, "scene.method", "['rk4']: must be a name, or a mapping"),
    ({**SCENE, "system": 3}, "scene.system", "3: must be a text"),
    ({**SCENE, "initial": {"M": [[1, 2], [3]]}}, "scene.initial.M", "[[1, 2], [3]]: must be a matrix"),
    ({**SCENE, "initial": [1]}, "scene.initial", "[1]: must be a mapping from names to matrices"),
    (3, "scene", "3: must be a dict"),
])
def test_unknown_fields_and_wrong_types_are_errors(scene, path, description, tmp_path):
    """Of a mapping, and of a file, whose keys are texts."""
    (tmp_path / "scene.json").write_text(json.dumps(scene))
    for given in (scene, tmp_path / "scene.json") if isinstance(scene, dict) and 3 not in scene else (scene,):
        with pytest.raises(stiefel.InvalidArgument) as caught:
            stiefel.to_message(given)
        violation, = caught.value.violations
        assert violation.field.endswith(path.removeprefix("scene")) and violation.description.startswith(description)
        assert f"{violation.field}: {description}" in str(caught.value)


def test_a_text_is_the_name_of_a_method(client, tmp_path):
    named, text = {**SCENE, "method": {"name": "rk4"}}, {**SCENE, "method": "rk4"}
    (tmp_path / "scene.json").write_text(json.dumps(text))
    assert stiefel.to_message(text) == stiefel.to_message(tmp_path / "scene.json") == stiefel.to_message(named)
    assert stiefel.body_scene(moments=[1, 2, 3], angular_velocity=[0, 0, 1], method="rk4")["method"] == "rk4"
    with client.create(text) as session, session.fork(at=3, method="munthe_kaas4") as fork:
        assert (session.scene["method"]["name"], fork.scene["method"]["name"]) == ("rk4", "munthe_kaas4")
    with pytest.raises(stiefel.InvalidArgument, match='^scene.method.name: "varational": must be .*; did you mean variational[?]$'):
        client.create({**SCENE, "method": "varational"})
    asked = {"to": 1, "summarize": {"energy": "last"}}
    both = stiefel.sweep(SCENE, axes={"method": ["rk4", {"name": "munthe_kaas4"}]}, **asked)
    assert both.equals(stiefel.sweep(SCENE, axes={"method": [{"name": "rk4"}, {"name": "munthe_kaas4"}]}, **asked))


def test_every_unknown_field_is_named():
    with pytest.raises(stiefel.InvalidArgument) as caught:
        stiefel.to_message({"sistem": "rigid_body", "method": {"nmae": "rk4", "ordr": 2}})
    fields = {violation.field for violation in caught.value.violations}
    assert fields == {"scene.sistem", "scene.method.nmae", "scene.method.ordr"}
