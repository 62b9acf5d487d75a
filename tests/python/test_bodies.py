"""Scenes from what people have: solids, attitudes in every form, velocities in both frames."""
import numpy as np
import pytest

import stiefel
from stiefel import solids

RNG = np.random.default_rng(5)


def turn(axis, angle):
    """Rodrigues' formula."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    K = np.cross(axis, np.eye(3)).T  # its columns are axis x e_j
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def sampled(mass, inside, box, count=100):
    """Centre and tensor of a solid by the points of a grid in a box."""
    points = (np.stack(np.meshgrid(*[np.arange(count) + 0.5] * 3), -1).reshape(-1, 3) / count - 0.5) * box
    points = points[inside(*points.T)]
    centre = points.mean(0)
    d = points - centre
    return centre, mass * (np.eye(3) * (d**2).sum() - d.T @ d) / len(points)


@pytest.mark.parametrize("solid, inside, box, height", [
    (solids.box(3, (1, 2, 4)), lambda x, y, z: x == x, (1, 2, 4), 0),
    (solids.ellipsoid(3, (0.5, 1, 2)), lambda x, y, z: (2 * x)**2 + y**2 + (z / 2)**2 < 1, (1, 2, 4), 0),
    (solids.cylinder(3, 0.7, 3), lambda x, y, z: x**2 + y**2 < 0.49, (1.4, 1.4, 3), 0),
    (solids.cone(3, 0.7, 3), lambda x, y, z: np.hypot(x, y) < 0.7 * (0.5 - z / 3), (1.4, 1.4, 3), -3 / 4),
], ids=["box", "ellipsoid", "cylinder", "cone"])
def test_a_solid_has_the_tensor_of_the_points_inside(solid, inside, box, height):
    centre, tensor = sampled(3, inside, np.array(box))
    assert np.allclose(solid.inertia_tensor, tensor, rtol=0, atol=2e-3 * tensor.max())
    assert np.allclose(centre, [0, 0, height], rtol=0, atol=2e-3), "a cone's centre of mass is at a quarter of its height"


def test_a_body_of_solids_is_that_of_its_points():
    """Two halves of a box, and turned points: sums over masses, with nothing of the package."""
    half = [solids.box(1.5, (1, 2, 2), at=(0, 0, z)) for z in (-1, 1)]
    assert np.allclose(sum(half).inertia_tensor, solids.box(3, (1, 2, 4)).inertia_tensor, rtol=1e-15)
    masses, places = RNG.uniform(1, 2, 6), RNG.standard_normal((6, 3))
    whole = sum(solids.point(mass, at=place) for mass, place in zip(masses, places))
    d = places - masses @ places / masses.sum()
    assert np.allclose(whole.inertia_tensor, sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, d)), rtol=1e-13)
    R = turn([1, 2, 3], 0.7)
    assert np.allclose(solids.box(3, (1, 2, 4), attitude=R).inertia_tensor, R @ np.diag([5, 4.25, 1.25]) @ R.T, rtol=1e-14)
    turned = solids.box(3, (1, 2, 4), attitude=[1, 0, 0, 1]).inertia_tensor
    assert np.allclose(turned, np.diag([4.25, 5, 1.25]), rtol=1e-14, atol=1e-14), "a quarter turn about z"
    assert stiefel.body_scene(inertia_tensor=half, angular_velocity=[0, 0, 1])["body"]["inertia_tensor"] == pytest.approx(
        [5, 4.25, 1.25, 0, 0, 0])


def test_solids_of_an_ensemble_are_a_list_for_each_member(client):
    """A list of as many solids as members could be either, and is refused."""
    solid = [solids.box(6, (1, 2, 3)), solids.box(6, (3, 2, 1)), solids.point(1, at=(0, 0, 1))]
    omega = [[0, 0, 1], [0, 1, 0]]
    expected = [one.inertia_tensor for one in (solid[0], solid[1] + solid[2])]
    for scene in (stiefel.body_scene(inertia_tensor=[solid[:1], solid[1:]], members=2, angular_velocity=omega, step=0.1),
                  {"system": "rigid_body", "step": 0.1, "members": 2,
                   "body": {"inertia_tensor": [solid[:1], solid[1:]], "angular_momentum": [I @ w for I, w in zip(expected, omega)]}}):
        with client.create(scene) as session:
            tensor = np.reshape(session.scene["body"]["inertia_tensor"], (2, 6))
            state = session.step(to=0, fields="angular_velocity")
        assert np.allclose(tensor, [[*np.diag(I), I[0, 1], I[0, 2], I[1, 2]] for I in expected], rtol=1e-15)
        assert np.allclose(state["angular_velocity"], omega, rtol=0, atol=1e-15)
    shared = {"inertia_tensor": solid, "members": 2, "angular_velocity": [0, 0, 1]}
    assert np.shape(stiefel.body_scene(**shared)["body"]["inertia_tensor"]) == (6,), "three solids for two members are one body"
    with pytest.raises(stiefel.InvalidArgument, match=r"inertia_tensor: 2 solids for 2 members: must be \[\[solid\], ...\]"):
        stiefel.body_scene(**{**shared, "inertia_tensor": solid[:2]})


class Rotation:
    """As scipy's, which need not be installed."""

    def __init__(self, matrix):
        self.as_matrix = lambda: matrix


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 2.0, np.pi - 1e-9, np.pi])
def test_every_form_of_an_attitude_is_the_same_rotation(angle):
    for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 2, 3], [-3, 1, 2]):
        unit = np.asarray(axis) / np.linalg.norm(axis)
        q = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * unit)])
        forms = [dict(attitude=q), dict(attitude=np.roll(q, -1), order="xyzw"), dict(attitude=turn(axis, angle)),
                 dict(attitude=Rotation(turn(axis, angle))), dict(mrp=np.tan(angle / 4) * unit)]
        for form in forms:
            found = np.array(stiefel.body_scene(moments=[1, 2, 3], angular_velocity=[0, 0, 1], **form)["body"]["attitude"])
            assert min(abs(found - q).max(), abs(found + q).max()) < 1e-15, form


@pytest.mark.parametrize("omega, step", [([0, 0, 2 * np.pi], 0.01), ([3, 0, 4], 0.01), ([0, 1e-3, 0], 60.0), ([0, 0, 0], 1.0),
                                         ([[1, 0, 0], [0, 100, 0]], 6e-4)])
def test_a_step_is_a_hundredth_of_a_turn(omega, step):
    members = len(omega) if np.ndim(omega) == 2 else None
    assert stiefel.body_scene(moments=[1, 2, 3], angular_velocity=omega, members=members)["step"] == step
    assert stiefel.body_scene(moments=[1, 2, 3], angular_velocity=omega, members=members, step=7.5)["step"] == 7.5


def test_velocity_and_momentum_in_both_frames(client):
    tensor = np.array([[4, 0.3, -0.2], [0.3, 5, 0.1], [-0.2, 0.1, 3]])
    Q, omega = turn([1, -2, 1], 1.1), np.array([0.1, 0.2, -0.3])
    for given in (dict(angular_velocity=omega), dict(angular_velocity=Q @ omega, frame="space"),
                  dict(angular_momentum=tensor @ omega), dict(angular_momentum=Q @ tensor @ omega, frame="space")):
        for inertia in (tensor, [4, 5, 3, 0.3, -0.2, 0.1]):
            scene = stiefel.body_scene(inertia_tensor=inertia, attitude=Q, step=0.1, **given)
            assert np.allclose(scene["body"]["angular_velocity"], omega, rtol=0, atol=1e-15), given
    with client.create(scene) as session:
        assert np.allclose(session.step(to=0, fields="Q")["Q"], Q, rtol=0, atol=1e-15)


AXES = dict(zip("xyz", np.eye(3)))


@pytest.mark.parametrize("sequence", ["ZXZ", "zxz", "ZYX", "zyx", "XYZ", "yzx", "YXY"])
def test_euler_angles_and_their_rates(client, sequence):
    """Beside the product of three turns, and its derivative Q' = Q hat(omega) by differences; at a middle angle of 0 too."""
    def product(angles):
        turns = [turn(AXES[axis], angle) for axis, angle in zip(sequence.lower(), angles)]
        return np.linalg.multi_dot(turns if sequence.isupper() else turns[::-1])

    for angles in ([0.3, -1.1, 2.5], [0.4, 0.0, 0.7]):
        angles, rates, h = np.array(angles), np.array([0.2, -0.5, 0.9]), 1e-5
        W = product(angles).T @ (product(angles + h * rates) - product(angles - h * rates)) / (2 * h)
        forms = {"euler_angles": angles, "sequence": sequence, "euler_rates": rates}
        scene = stiefel.to_message({"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], **forms}})
        assert np.allclose(scene.body.angular_velocity, [W[2, 1], W[0, 2], W[1, 0]], rtol=0, atol=1e-9)
        state = client.create(scene).step(to=0, fields=["Q", "angular_velocity"])
        assert np.allclose(state["Q"], product(angles), rtol=0, atol=1e-15)
        both = stiefel.to_message({"members": 2, "body": {"moments": [1, 2, 3], "sequence": sequence, "euler_angles": [angles, angles[::-1]],
                                                          "euler_rates": [rates, 2 * rates]}}).body
        assert list(both.angular_velocity[:3]) == list(scene.body.angular_velocity) and list(both.attitude[:4]) == list(scene.body.attitude)
        made = stiefel.body_scene(moments=[1, 2, 3], euler_angles=angles, sequence=sequence, angular_velocity=scene.body.angular_velocity, step=0.1)
        assert np.allclose(stiefel.to_message(made).body.attitude, scene.body.attitude, rtol=0, atol=1e-15)


EULER = {"euler_angles": [1, 2, 3], "sequence": "ZXZ"}


@pytest.mark.parametrize("given, told", [
    ({"euler_angles": [1, 2, 3]}, r"sequence: None: must be three of X, Y, Z for axes that turn with the body, or of x, y, z"),
    ({**EULER, "sequence": "ZXx"}, r"sequence: 'ZXx': must be three of"), ({**EULER, "sequence": 313}, "sequence: 313: must"),
    ({**EULER, "sequence": "ZZX"}, "sequence: 'ZZX': must be three of .* no two equal in a row"),
    ({**EULER, "euler_angles": [1, 2]}, r"euler_angles: the shape \(2,\): must be \(3\)"),
    ({**EULER, "attitude": [1, 0, 0, 0]}, r"attitude: \[1.0, 0.0, 0.0, 0.0\]: must be absent where euler_angles is given"),
    ({"euler_rates": [1, 2, 3]}, r"euler_rates: \[1.0, 2.0, 3.0\]: must be absent where euler_angles is not given"), ({"sequence": "ZXZ"}, "sequence: 'ZXZ': must be absent where"),
    ({**EULER, "euler_rates": [1, 2, 3], "angular_velocity": [1, 2, 3]}, r"angular_velocity: \[.*\]: must be absent where"),
    ({**EULER, "euler_angles": "ZXZ"}, "euler_angles: 'ZXZ': must be numbers in rad, or a quantity that converts to it"),
    ({"order": "zyx"}, "order: 'zyx': must be one of wxyz, xyzw"), ({"order": "xyzw"}, "order: 'xyzw': must be absent where attitude is not given"),
    ({"mrp": [0, 0]}, r"mrp: the shape \(2,\): must be \(3\)"), ({"mrp": [0, 0, 0], "attitude": [1, 0, 0, 0]}, "attitude: .*: must be absent where mrp")])
def test_forms_that_do_not_fit_are_refused(given, told):
    with pytest.raises(stiefel.InvalidArgument, match=rf"scene\.body\.{told}"):
        stiefel.to_message({"system": "rigid_body", "body": {"moments": [1, 2, 3], **given}})


@pytest.mark.parametrize("given, told", [
    (dict(attitude=[0.7071, 0.7071, 0, 0]), "attitude: .* of norm 0.9999904.*: must have norm 1 to 1e-06; normalize=True makes it so"),
    (dict(attitude=np.round(turn([1, 2, 3], 1), 5)), "attitude: max .* = .*e-06: must be a rotation .*; normalize=True makes it so"),
    (dict(attitude=[0, 0, 0, 0]), "of norm 0: must have norm 1 to 1e-06$"),
    (dict(attitude=np.diag([1, 1, -1.0])), "the determinant is -1"), (dict(attitude=[1, 0, 0]), r"the shape \(3,\)"), (dict(frame="inertial"), "frame: 'inertial'"),
    (dict(inertia_tensor=[[1, 0.1, 0], [0, 2, 0], [0, 0, 2]], moments=None), r"inertia_tensor: max \|I - I\^T\| = 0.1"),
    (dict(attitude=[0, 0, 0, 0], normalize=True), r"attitude: \[0.0, 0.0, 0.0, 0.0\]: must have a finite norm above 0"),
    (dict(inertia_tensor=np.eye(3)), "moments: exactly one"), (dict(angular_momentum=[1, 0, 0]), "exactly one of angular_velocity")])
def test_what_is_wrong_is_refused_with_its_rule(given, told):
    with pytest.raises(stiefel.InvalidArgument, match=told):
        stiefel.body_scene(**{"moments": [1, 2, 3], "angular_velocity": [0, 0, 1], **given})


def test_a_scene_takes_what_a_body_takes(client):
    """A dict and a file mean what stiefel.body_scene makes of them; a matrix is the attitude, for each member too."""
    Q, q = turn([1, 2, 3], 1), [np.cos(0.5), *np.sin(0.5) * np.array([1, 2, 3]) / 14**0.5]
    for forms in ({"attitude": [0, 0, 0.6, 0.8], "order": "xyzw", "angular_velocity": [1, 2, 3], "frame": "space"}, {"attitude": Q.tolist(), "angular_velocity": [1, 2, 3]},
                  {"attitude": Rotation(Q), "angular_velocity": [1, 2, 3]}, {"mrp": [0.1, 0.2, 0.3], "angular_momentum": [1, 2, 3]},
                  {"attitude": Q, "angular_momentum": [1, 2, 3], "frame": "space"}):
        scene = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], **forms}}
        assert stiefel.to_message(scene) == stiefel.to_message(stiefel.body_scene(moments=[1, 2, 3], step=0.1, **forms))
    both = stiefel.to_dict({"members": 2, "body": {"inertia_tensor": solids.box(6, (1, 2, 3), at=(1, 0, 0)), "attitude": [Q, Q.T]}})["body"]
    assert np.allclose(both["attitude"], [*q, *q * np.array([1, -1, -1, -1])], rtol=0, atol=1e-15)
    assert np.allclose(both["inertia_tensor"], [6.5, 5, 2.5, 0, 0, 0], rtol=1e-15)  # m (b^2 + c^2) / 12
    rounded = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "attitude": [0.7071, 0, 0, 0.7071], "angular_velocity": [1, 2, 3]}}
    assert client.create({**rounded, "normalize": True}).scene["body"]["attitude"] == pytest.approx([0.5**0.5, 0, 0, 0.5**0.5])


def test_five_digits_are_enough_with_normalize(client):
    Q = turn([1, 2, 3], 1)
    scene = stiefel.body_scene(moments=[1, 2, 3], attitude=np.round(Q, 5), angular_velocity=[0, 0, 1], normalize=True)
    with client.create(scene) as session:
        assert abs(session.step(to=0, fields="Q")["Q"] - Q).max() < 1e-5
    frame, velocity = np.array([[0.6, 0.8, 0, 0], [0, 0, 0.6, 0.8]]), np.array([[0, 0, 1, 1.75], [-1.2, -1.6, 0.8, -0.6]])
    velocity += 1e-5 * RNG.standard_normal((2, 4))
    rounded = {"system": "stiefel", "inertia": [1, 2, 3, 4], "step": 0.1, "initial": {"Q": frame + 1e-5, "Qdot": velocity}}
    with pytest.raises(stiefel.InvalidArgument, match="initial.Q: .*rows to 1e-06; normalize=True makes it so"):
        client.create(rounded)
    with client.create(rounded, normalize=True) as session:
        state = session.step(to=0, fields=["Q", "Qdot"])
        assert abs(state["Q"] @ state["Q"].T - np.eye(2)).max() < 1e-15
        assert abs(state["Q"] @ state["Qdot"].T + state["Qdot"] @ state["Q"].T).max() < 1e-14
        assert abs(state["Q"] - frame).max() < 2e-5 and abs(state["Qdot"] - velocity).max() < 2e-4


@pytest.mark.parametrize("system", ["rigid_body", "right_rigid_body", "symmetric_rigid_body", "mclachlan_scovel", "reduced_rigid_body"])
def test_a_body_in_four_dimensions_by_its_velocity(client, system):
    """The field Omega of the state is what was given."""
    Omega, Q = np.triu(RNG.standard_normal((4, 4)), 1), np.linalg.qr(RNG.standard_normal((4, 4)))[0]
    Omega -= Omega.T
    Qdot = Omega @ Q if system.startswith("right") else Q @ Omega
    for given in ({"Omega": Omega}, {"Qdot": Qdot}):
        with client.create({"system": system, "inertia": [1, 2, 3, 5], "step": 0.01, "initial": {"Q": Q, **given}}) as session:
            assert np.allclose(session.step(to=0, fields="Omega")["Omega"], Omega, rtol=0, atol=1e-13), given


@pytest.mark.parametrize("system", ["stiefel", "stiefel_costate", "stiefel_momentum"])
def test_a_frame_by_its_velocity(client, system):
    Q = np.linalg.qr(RNG.standard_normal((5, 2)))[0].T
    U = RNG.standard_normal((5, 5))
    Qdot = Q @ (U - U.T)
    scene = {"system": system, "inertia": [1, 2, 3, 4, 5], "step": 0.01, "initial": {"Q": Q, "Qdot": Qdot}}
    with client.create(scene) as session:
        assert np.allclose(session.step(to=0, fields="Qdot")["Qdot"], Qdot, rtol=0, atol=1e-13)
    for change, told in (({"initial": {"Q": Q.T, "Qdot": Qdot.T}}, r"^scene.initial.Qdot: the shape \(5, 2\): .* it looks transposed"),
                         ({"initial": {"Q": Q, "Qdot": Qdot, "S": Qdot}}, "initial.Qdot: must be absent where S is given"),
                         ({"inertia": None}, "scene.inertia: absent"), ({"inertia": [1, 2, 3]}, r"the shape \(2, 5\): .* has numbers, 3$"),
                         ({"inertia": [1, 2]}, r"the shape \(2, 5\): .* has numbers, 2$")):
        with pytest.raises(stiefel.InvalidArgument, match=told):
            client.create({**scene, **change})
    with pytest.raises(stiefel.InvalidArgument, match=r"initial.Omega: max \|Omega \+ Omega\^T\| = 2: must be skew-symmetric"):
        client.create({"system": "rigid_body", "inertia": np.ones(4), "step": 1, "initial": {"Omega": np.ones((4, 4))}})
    with pytest.raises(stiefel.InvalidArgument, match="initial.Omega: must be absent: stiefel takes Qdot"):
        client.create({**scene, "system": "stiefel", "initial": {"Q": Q, "Omega": U}})
