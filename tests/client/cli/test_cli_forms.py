"""Scenes as people have them: the command reads the forms that the Python client reads, and makes the same scene of them."""
import json

import numpy as np
import pytest

client = pytest.importorskip("stiefel")
rng = np.random.default_rng(7)
Q3 = np.linalg.qr(rng.normal(size=(3, 3)))[0]
Q3 *= np.linalg.det(Q3)
Q4 = np.linalg.qr(rng.normal(size=(4, 4)))[0]
Q25 = np.linalg.qr(rng.normal(size=(5, 2)))[0].T
W = rng.normal(size=(4, 4))
W = W - W.T
V = rng.normal(size=(2, 5))
V = V - (V @ Q25.T + Q25 @ V.T) / 2 @ Q25
TENSOR = [[2, 0.1, 0.2], [0.1, 3, 0], [0.2, 0, 4]]
QUATERNION = np.array([0.5, 0.1, -0.7, 0.5]) / np.linalg.norm([0.5, 0.1, -0.7, 0.5])


def body(**fields):
    return {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": [0.3, 1, 0.2], **fields}}


def momentum(**fields):
    scene = body(angular_momentum=[0.3, 2, 0.6], **fields)
    del scene["body"]["angular_velocity"]
    return scene


def frame(system, **initial):
    inertia = [1, 2, 3, 4] if np.shape(next(iter(initial.values())))[-1] == 4 else [1, 2, 3, 4, 5]
    return {"system": system, "step": 0.05, "inertia": inertia,
            "initial": {name: np.asarray(block).tolist() for name, block in initial.items()}}


def members(scene, **fields):
    return {**scene, "members": 2, **fields}


FORMS = {
    "order": body(attitude=QUATERNION[[1, 2, 3, 0]].tolist(), order="xyzw"),
    "matrix": body(attitude=Q3.tolist()),
    "mrp": body(mrp=[0.1, 0.2, -0.3]),
    "tensor": {**body(inertia_tensor=TENSOR, moments=None)},
    "space": body(attitude=QUATERNION.tolist(), frame="space"),
    "momentum": momentum(),
    "momentum, tensor, space": momentum(inertia_tensor=TENSOR, moments=None, attitude=Q3.tolist(), frame="space"),
    "members": members(momentum(attitude=[[0, 0, 0, 1], [1, 0, 0, 0]], order="xyzw", frame="space")),
    "lists of members": members(body(moments=[[1, 2, 3], [2, 3, 4]], angular_velocity=[[1, 2, 3], [4, 5, 6]])),
    "tensors of members": members(body(moments=None, inertia_tensor=[TENSOR, (2 * np.array(TENSOR)).tolist()])),
    "Omega": frame("rigid_body", Q=Q4, Omega=W),
    "Omega, right": frame("right_symmetric_rigid_body", Q=Q4, Omega=W),
    "Omega, members": members(frame("rigid_body", Q=np.stack([Q4, Q4]), Omega=np.stack([W, 2 * W]))),
    "Qdot": frame("rigid_body", Q=Q4, Qdot=Q4 @ W),
    "Qdot, right": frame("right_rigid_body", Q=Q4, Qdot=W @ Q4),
    "Qdot, S": frame("stiefel", Q=Q25, Qdot=V),
    "Qdot, P": frame("stiefel_costate", Q=Q25, Qdot=V),
    "Qdot, M": frame("stiefel_momentum", Q=Q25, Qdot=V),
    "normalize": {**frame("stiefel", Q=np.round(Q25, 5), Qdot=np.round(V, 5)), "normalize": True},
    "normalize, M": {**frame("rigid_body", Q=np.round(Q4, 5), M=np.round(W, 5) + 1e-6), "normalize": True},
    "normalize, body": {**body(attitude=np.round(Q3, 5).tolist()), "normalize": True},
    "normalize, quaternion": {**body(attitude=np.round(QUATERNION, 4).tolist()), "normalize": True},
}


def numbers(value, path=""):
    """Every number of a scene by its path."""
    if isinstance(value, dict):
        return {place: number for name, one in value.items() for place, number in numbers(one, f"{path}.{name}").items()}
    if isinstance(value, list):
        return {place: number for k, one in enumerate(value) for place, number in numbers(one, f"{path}[{k}]").items()}
    return {path: value}


@pytest.fixture(scope="module")
def there():
    with client.Server.start() as server, client.Client(server.address) as connected:
        yield connected


@pytest.mark.parametrize("form", FORMS)
def test_a_form_is_that_of_the_python_client(stiefel, write, there, form):
    """To rounding; where no division or root is taken, to the last bit."""
    scene = FORMS[form]
    found = stiefel("run", write(scene), "--to", 0)
    assert found.status == 0, found.err
    with there.create(scene) as session:
        expected = session.scene
    found, expected = numbers(json.loads(found.out)["scene"]), numbers(json.loads(json.dumps(expected)))
    assert found.keys() == expected.keys()
    for path, number in expected.items():
        if form.startswith(("Qdot", "normalize", "momentum", "matrix", "mrp", "space", "members")) and isinstance(number, float):
            assert found[path] == pytest.approx(number, rel=0, abs=4e-15), path
        else:
            assert found[path] == number, path


def test_changes_may_complete_a_form(stiefel, write):
    done = stiefel("run", write(body(attitude=[0, 0, 0, 1])), "--to", 0, "--set", "body.order=xyzw", "--fields", "quaternion")
    assert done.status == 0 and done.json["samples"][0]["fields"]["quaternion"] == [1, 0, 0, 0]
    rounded = write(body(attitude=[0.7071, 0, 0, 0.7071]))
    assert stiefel("run", rounded, "--to", 0).status == 2
    assert stiefel("run", rounded, "--to", 0, "--set", "normalize=true").status == 0


def test_a_quaternion_of_any_norm_is_an_attitude(stiefel, write):
    done = stiefel("run", write({**body(attitude=[0, 4, 0, 3]), "normalize": True}), "--to", 0, "--fields", "quaternion")
    assert done.status == 0 and done.json["samples"][0]["fields"]["quaternion"] == [0, 0.8, 0, 0.6]


def test_a_text_is_the_name_of_a_method(stiefel, write):
    named = stiefel("run", write({**body(), "method": {"name": "rk4", "order": 4}}), "--to", 3)
    for scene, change in ((write({**body(), "method": "rk4"}), ["method.substeps=1"]), (write(body(), "plain.json"), ["method=rk4"])):
        done = stiefel("run", scene, "--to", 3, *(word for one in change for word in ("--set", one)))
        assert done.status == 0 and done.json["samples"] == named.json["samples"]
    wrong = stiefel("diagnose", write(body()), "--to", 3, "--method", "rk4")
    assert wrong.status == 2 and "A scene's field is set by --set method=VALUE" in wrong.err


@pytest.mark.parametrize("scene, told", [
    (body(order="zyxw"), 'body.order: "zyxw": must be one of wxyz, xyzw'),
    (body(frame="camera"), 'body.frame: "camera": must be one of body, space'),
    (body(ordre="xyzw"), "body.ordre: unknown field; did you mean order?"),
    (body(mrp=[0, 0, 1], attitude=[1, 0, 0, 0]), "body.mrp: must be absent where attitude is given"),
    (body(angular_momentum=[1, 2, 3]), "body.angular_momentum: must be absent where angular_velocity is given"),
    (momentum(moments=None), "body.angular_momentum: needs moments or inertia_tensor"),
    (body(attitude=[0, 0, 1], order="xyzw"), "body.attitude: 3 numbers: must be a quaternion or a rotation matrix"),
    (body(attitude=(2 * Q3).tolist()), "must be a rotation to 1e-06"),
    (body(attitude=np.round(Q3, 4).tolist()), '"normalize": true makes it so'),
    (body(attitude=(-Q3).tolist()), "the determinant is -1"),
    (body(moments=None, inertia_tensor=[[1, 2, 0], [0, 1, 0], [0, 0, 1]]), "body.inertia_tensor: max |I - Iᵀ| = 2: must be a symmetric matrix"),
    (frame("rigid_body", Q=Q4, Omega=W + 0.1), "initial.Omega: max |M + Mᵀ|"),
    (frame("stiefel", Q=Q25, Qdot=V + 1), "initial.Qdot: max |Q̇Qᵀ + QQ̇ᵀ|"),
    ({**frame("stiefel", Q=Q25.T, Qdot=V.T), "inertia": [1, 2, 3, 4, 5]}, "initial.Qdot: is 5 x 2: must have as many columns as inertia has numbers, 5; it looks transposed"),
    ({**frame("stiefel", Q=Q25, Qdot=V), "inertia": [1, 2]}, "initial.Qdot: is 2 x 5: must have as many columns as inertia has numbers, 2\n"),
    (frame("rigid_body", Q=Q4, Omega=W, M=W), "initial.Omega: must be absent where M is given"),
    (frame("stiefel", Q=Q25, Omega=V), "initial.Omega: must be absent: stiefel takes Qdot"),
    ({**body(attitude=[0, 0, 0, 0]), "normalize": True}, "body.attitude: of norm 0: must have a finite norm above 0"),
    ({**body(), "method": 3}, "method: 3: must be a name, or an object with the fields name, order, substeps, "),
    ({**body(), "method": "varational"}, "; did you mean variational?"),
    ({**body(), "torque": [0, 0, 1]}, "torque: unknown field; there are no torques and no forces: the motion is free"),
    (body(force=1), "body.force: unknown field; there are no torques and no forces: the motion is free"),
    ({**body(), "normalize": 1}, "normalize: 1: must be true or false")])
def test_a_wrong_form_is_refused(stiefel, write, scene, told):
    done = stiefel("run", write(scene), "--to", 1)
    assert done.status == 2 and told in done.err and len(done.err.splitlines()) == 1, done.err
