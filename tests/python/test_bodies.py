"""Scenes from what people have: solids, attitudes in every form, velocities in both frames, periods of light curves."""
from types import SimpleNamespace

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


def sampled(mass, inside, box, count=400_000):
    """Mass, centre and tensor of a solid by points that fill a box evenly (a Halton sequence)."""
    def halton(base):
        result, f, i = np.zeros(count), 1.0, np.arange(1, count + 1)
        while i.any():
            f /= base
            result, i = result + f * (i % base), i // base
        return result

    points = (np.stack([halton(base) for base in (2, 3, 5)], -1) - 0.5) * box
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
    rounded = solids.box(3, (1, 2, 4), attitude=np.round(R, 4)).inertia_tensor
    assert np.allclose(rounded, R @ np.diag([5, 4.25, 1.25]) @ R.T, rtol=0, atol=1e-3) and np.trace(rounded) == pytest.approx(10.5, rel=1e-14)
    turned = solids.box(3, (1, 2, 4), attitude=[1, 0, 0, 1]).inertia_tensor
    assert np.allclose(turned, np.diag([4.25, 5, 1.25]), rtol=1e-14, atol=1e-14), "a quarter turn about z"
    assert stiefel.body(inertia_tensor=half, angular_velocity=[0, 0, 1])["body"]["inertia_tensor"] == pytest.approx(
        [5, 4.25, 1.25, 0, 0, 0])


def test_solids_of_an_ensemble_are_a_list_for_each_member(client):
    """A list of as many solids as members could be either, and is refused."""
    solid = [solids.box(6, (1, 2, 3)), solids.box(6, (3, 2, 1)), solids.point(1, at=(0, 0, 1))]
    omega = [[0, 0, 1], [0, 1, 0]]
    expected = [one.inertia_tensor for one in (solid[0], solid[1] + solid[2])]
    for scene in (stiefel.body(inertia_tensor=[solid[:1], solid[1:]], members=2, angular_velocity=omega, step=0.1),
                  {"system": "rigid_body", "step": 0.1, "members": 2,
                   "body": {"inertia_tensor": [solid[0], solid[1:]], "angular_velocity": omega}},
                  {"system": "rigid_body", "step": 0.1, "members": 2,
                   "body": {"inertia_tensor": [solid[:1], solid[1:]], "angular_momentum": [I @ w for I, w in zip(expected, omega)]}}):
        with client.create(scene) as session:
            tensor = np.reshape(session.scene["body"]["inertia_tensor"], (2, 6))
            state = session.step(to=0, fields="angular_velocity")
        assert np.allclose(tensor, [[*np.diag(I), I[0, 1], I[0, 2], I[1, 2]] for I in expected], rtol=1e-15)
        assert np.allclose(state["angular_velocity"], omega, rtol=0, atol=1e-15)
    shared = {"inertia_tensor": solid, "members": 2, "angular_velocity": [0, 0, 1]}
    assert np.shape(stiefel.body(**shared)["body"]["inertia_tensor"]) == (6,), "three solids for two members are one body"
    for make in (lambda: stiefel.body(**{**shared, "inertia_tensor": solid[:2]}),
                 lambda: stiefel.to_message({"members": 2, "body": {"inertia_tensor": solid[:2], "angular_velocity": [0, 0, 1]}})):
        with pytest.raises(stiefel.InvalidArgument, match=r"inertia_tensor: 2 solids for 2 members: must be \[\[solid\], ...\]"):
            make()


class Rotation:
    """As scipy's, which need not be installed: scalar last."""

    def __init__(self, quaternion):
        self.quaternion = quaternion

    def as_quat(self):
        return np.roll(self.quaternion, -1)

    def as_matrix(self):
        raise NotImplementedError


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 2.0, np.pi - 1e-9, np.pi])
def test_every_form_of_an_attitude_is_the_same_rotation(angle):
    for axis in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 2, 3], [-3, 1, 2]):
        unit = np.asarray(axis) / np.linalg.norm(axis)
        q = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * unit)])
        forms = [dict(attitude=q), dict(attitude=np.roll(q, -1), order="xyzw"), dict(attitude=turn(axis, angle)),
                 dict(attitude=Rotation(q)), dict(mrp=np.tan(angle / 4) * unit)]
        for form in forms:
            found = np.array(stiefel.body(moments=[1, 2, 3], angular_velocity=[0, 0, 1], **form)["body"]["attitude"])
            assert min(abs(found - q).max(), abs(found + q).max()) < 1e-15, form


@pytest.mark.parametrize("omega, step", [([0, 0, 2 * np.pi], 0.01), ([3, 0, 4], 0.01), ([0, 1e-3, 0], 60.0), ([0, 0, 0], 1.0),
                                         ([[1, 0, 0], [0, 100, 0]], 6e-4)])
def test_a_step_is_a_hundredth_of_a_turn(omega, step):
    assert stiefel.body(moments=[1, 2, 3], angular_velocity=omega)["step"] == step
    assert stiefel.body(moments=[1, 2, 3], angular_velocity=omega, step=7.5)["step"] == 7.5


def test_scipy_s_rotation_is_taken():
    Rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    R = Rotation.from_euler("zyx", [0.3, -1, 2])
    scene = stiefel.body(moments=[1, 2, 3], attitude=R, angular_velocity=[0, 0, 0.1])
    assert np.allclose(stiefel.simulate(scene, to=1, fields="Q")["Q"][0], R.as_matrix(), atol=1e-15)


def test_velocity_and_momentum_in_both_frames(client):
    tensor = np.array([[4, 0.3, -0.2], [0.3, 5, 0.1], [-0.2, 0.1, 3]])
    Q, omega = turn([1, -2, 1], 1.1), np.array([0.1, 0.2, -0.3])
    for given in (dict(angular_velocity=omega), dict(angular_velocity=Q @ omega, frame="space"),
                  dict(angular_momentum=tensor @ omega), dict(angular_momentum=Q @ tensor @ omega, frame="space")):
        for inertia in (tensor, [4, 5, 3, 0.3, -0.2, 0.1]):
            scene = stiefel.body(inertia_tensor=inertia, attitude=Q, step=0.1, **given)
            assert np.allclose(scene["body"]["angular_velocity"], omega, rtol=0, atol=1e-15), given
    with client.create(scene) as session:
        assert np.allclose(session.step(to=0, fields="Q")["Q"], Q, rtol=0, atol=1e-15)


@pytest.mark.parametrize("given, told", [
    (dict(attitude=[0.7071, 0.7071, 0, 0]), "attitude: .* of norm 0.9999904.*: must have norm 1 to 1e-06; normalize=True makes it so"),
    (dict(attitude=np.round(turn([1, 2, 3], 1), 5)), "attitude: max .* = .*e-06: must be a rotation .*; normalize=True"),
    (dict(attitude=[1, 1, 0, 0]), "of norm 1.41.*: must have norm 1 to 1e-06; normalize=True makes it so"),
    (dict(attitude=[0, 0, 0, 0]), "of norm 0: must have norm 1 to 1e-06$"),
    (dict(attitude=[0, 0, 0, 0], normalize=True), r"attitude: \[0.0, 0.0, 0.0, 0.0\]: must have a finite norm above 0"),
    (dict(attitude=np.diag([1, 1, -1.0])), "the determinant is -1"), (dict(attitude=[1, 0, 0]), r"the shape \(3,\)"),
    (dict(attitude=[1, 0, 0, 0], order="wxzy"), "order: 'wxzy'"), (dict(frame="inertial"), "frame: 'inertial'"),
    (dict(inertia_tensor=[[1, 0.1, 0], [0, 2, 0], [0, 0, 2]], moments=None), r"inertia_tensor: max \|I - I\^T\| = 0.1"),
    (dict(inertia_tensor=np.eye(3)), "moments: exactly one"), (dict(angular_momentum=[1, 0, 0]), "exactly one of angular_velocity"),
])
def test_what_is_wrong_is_refused_with_its_rule(given, told):
    with pytest.raises(stiefel.InvalidArgument, match=told):
        stiefel.body(**{"moments": [1, 2, 3], "angular_velocity": [0, 0, 1], **given})


def test_a_scene_takes_what_a_body_takes(client):
    Q, solid = turn([1, 2, 3], 1), solids.box(6, (1, 2, 3), at=(1, 0, 0))
    q = np.array([np.cos(0.5), *np.sin(0.5) * np.array([1, 2, 3]) / 14**0.5])
    scipy = SimpleNamespace(as_quat=lambda: np.roll(q, -1), as_matrix=lambda: Q)  # a Rotation of scipy has both
    for attitude in (Q, Q.tolist(), scipy):
        scene = stiefel.to_dict({"system": "rigid_body", "step": 0.1, "body": {"inertia_tensor": solid, "attitude": attitude}})["body"]
        assert np.allclose(scene["attitude"], q, rtol=0, atol=1e-15)
        assert np.allclose(scene["inertia_tensor"], [6.5, 5, 2.5, 0, 0, 0], rtol=1e-15)  # m (b^2 + c^2) / 12
    both = stiefel.to_dict({"members": 2, "body": {"moments": [1, 2, 3], "attitude": [Q, Q.T]}})["body"]["attitude"]
    assert np.allclose(both, [*q, *q * [1, -1, -1, -1]], rtol=0, atol=1e-15)
    with pytest.raises(stiefel.InvalidArgument, match=r"attitude: max .* = .*e-06: must be a rotation .*; normalize=True makes it so"):
        stiefel.to_dict({"body": {"attitude": np.round(Q, 5)}})
    with pytest.raises(stiefel.InvalidArgument, match="scene.body.attitude: the determinant is -1"):
        stiefel.to_dict({"body": {"attitude": -Q}})


def test_five_digits_are_enough_with_normalize(client):
    Q = turn([1, 2, 3], 1)
    scene = stiefel.body(moments=[1, 2, 3], attitude=np.round(Q, 5), angular_velocity=[0, 0, 1], normalize=True)
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
    with pytest.raises(stiefel.InvalidArgument, match="initial.Qdot: must be absent where S is given"):
        client.create({**scene, "initial": {**scene["initial"], "S": Qdot}})
    for change, told in (({"initial": {"Q": Q.T, "Qdot": Qdot.T}}, r"initial.Qdot: the shape \(5, 2\): .* it looks transposed"),
                         ({"inertia": None}, "scene.inertia: absent"), ({"inertia": [1, 2, 3]}, r"the shape \(2, 5\): .* has numbers, 3$"),
                         ({"inertia": [1, 2]}, r"the shape \(2, 5\): .* has numbers, 2$")):
        with pytest.raises(stiefel.InvalidArgument, match=told):
            client.create({**scene, **change})
    with pytest.raises(stiefel.InvalidArgument, match=r"initial.Omega: max \|Omega \+ Omega\^T\| = 2: must be skew-symmetric"):
        client.create({"system": "rigid_body", "inertia": np.ones(4), "step": 1, "initial": {"Omega": np.ones((4, 4))}})
    with pytest.raises(stiefel.InvalidArgument, match="initial.Omega: must be absent: stiefel takes Qdot"):
        client.create({**scene, "system": "stiefel", "initial": {"Q": Q, "Omega": U}})


def measured(scene, axis, turns):
    """P_phi and P_psi of a simulated motion, from the angles of its samples about the pole z, and E / E_0."""
    run = stiefel.simulate(scene, times=np.linspace(0, turns, 20001), fields=["Q", "angular_velocity"])
    Q, places = run["Q"], [(axis + 1) % 3, (axis + 2) % 3, axis]
    phi = np.unwrap(np.arctan2(Q[:, 0, axis], -Q[:, 1, axis]))
    psi = np.unwrap(np.arctan2(Q[:, 2, places[0]], Q[:, 2, places[1]]))
    whole = np.flatnonzero(np.diff(np.floor(np.abs(psi - psi[0]) / (2 * np.pi))) > 0)[-1]  # the last whole turn of psi
    t = run.time[whole:whole + 2]
    at = lambda angle: np.interp(2 * np.pi * round(abs(psi[whole] - psi[0]) / (2 * np.pi)), np.abs(psi[whole:whole + 2] - psi[0]), angle)
    end, count = at(t), round(abs(psi[whole] - psi[0]) / (2 * np.pi))
    return 2 * np.pi * end / (at(phi[whole:whole + 2]) - phi[0]), end / count, np.sign(psi[-1] - psi[0])


@pytest.mark.parametrize("mode, axis, ratio", [("SAM", 2, 0.104), ("SAM", 2, 0.04), ("LAM", 0, 0.2), ("LAM", 0, 0.05)])
def test_the_periods_are_those_asked_for(mode, axis, ratio):
    scene = stiefel.tumbling(3600.0, 3600.0 / ratio, mode, moments=[0.61, 0.965, 1], psi=0.0)
    P_phi, P_psi, sense = measured(scene, axis, 4.2 * 3600 / ratio)
    assert P_phi == pytest.approx(3600, rel=1e-6) and P_psi == pytest.approx(3600 / ratio, rel=1e-6)
    motion = stiefel.simulate(scene, to=1).motion
    assert (motion.P_phi, motion.P_psi) == pytest.approx((3600, 3600 / ratio), rel=1e-9)
    assert sense == (-1 if mode == "SAM" else 1)


def test_a_symmetric_body_has_the_closed_form():
    """I = (1, 2, 2), LAM: phi' = L / 2, psi' = L cos(theta) / 2, so that P_phi / P_psi = cos(theta)."""
    scene = stiefel.tumbling(100.0, 125.0, "LAM", moments=[1, 2, 2], phi=0.4, psi=0.9, pole=[0.3, 0.6])
    omega, L = np.array(scene["body"]["angular_velocity"]), 2 * 2 * np.pi / 100
    m = omega * [1, 2, 2]
    assert np.linalg.norm(m) == pytest.approx(L, rel=1e-13) and m[0] / L == pytest.approx(0.8, rel=1e-12)
    assert np.arctan2(m[1], m[2]) == pytest.approx(0.9, abs=1e-12)
    Q = stiefel.simulate(scene, to=1, fields="Q")["Q"][0]
    assert np.allclose(Q @ m, L * np.array([np.cos(0.6) * np.cos(0.3), np.cos(0.6) * np.sin(0.3), np.sin(0.6)]), rtol=0, atol=1e-13)


def test_apophis():
    """Pravec et al. 2014: P_phi 27.38 h, P_psi 263 h, SAM, I_1/I_3 0.61, I_2/I_3 0.965; E / E_0 1.024 +- 0.013."""
    scene = stiefel.tumbling(27.38 * 3600, 263 * 3600, "SAM", moments=[0.61, 0.965, 1])
    omega = np.array(scene["body"]["angular_velocity"])
    I = np.array([0.61, 0.965, 1])
    E, L = (I * omega**2).sum() / 2, np.linalg.norm(I * omega)
    assert E / (L**2 / 2) == pytest.approx(1.024, abs=0.013)


@pytest.mark.parametrize("given, told", [
    (dict(P_psi=1.5 * 3600), r"P_psi: 5400.0: P_phi / P_psi is 0.666667, and must be between .* for this body and mode"),
    (dict(mode="XAM"), "mode: 'XAM': must be SAM or LAM"), (dict(P_phi=0.0), "P_phi: 0.0: must be above 0"),
    (dict(moments=None), "moments: exactly one"), (dict(pole=[1, 2, 3, 4]), "pole"), (dict(moments=[1, 2, -1]), "three numbers above 0")])
def test_no_motion_has_other_periods(given, told):
    with pytest.raises(stiefel.InvalidArgument, match=told):
        stiefel.tumbling(**{"P_phi": 3600.0, "P_psi": 36000.0, "mode": "SAM", "moments": [0.61, 0.965, 1], **given})


def test_the_axes_of_an_ellipsoid_decide_its_moments():
    """Moments (b^2 + c^2, ...) / 5 of semi-axes: their ratios for (3, 2, 1) are 5 : 10 : 13."""
    by_axes = stiefel.tumbling(3600.0, 36000.0, "SAM", axis_ratios=[3, 2, 1])
    by_moments = stiefel.tumbling(3600.0, 36000.0, "SAM", moments=[5, 10, 13])
    assert by_axes["body"]["angular_velocity"] == pytest.approx(by_moments["body"]["angular_velocity"], rel=1e-12)


def test_an_error_names_what_was_given(client):
    """Omega and Qdot, of which the client makes the blocks that the server knows."""
    W = np.array([[0, 1, 2, 3], [-1, 0, 4, 5], [-2, -4, 0, 6], [-3, -5, -6, 0.5]])
    body = {"system": "rigid_body", "step": 0.1, "inertia": [1, 2, 3, 4], "initial": {"Q": np.eye(4), "Omega": W}}
    frame = {"system": "stiefel", "step": 0.1, "inertia": [1, 2, 3], "initial": {"Q": np.eye(2, 3), "Qdot": np.ones((2, 3))}}
    for scene, name in ((body, "Omega"), (frame, "Qdot")):
        with pytest.raises(stiefel.InvalidArgument, match=rf"^scene\.initial\.{name}: ") as caught:
            client.create(scene)
        assert caught.value.violations[0].field == f"scene.initial.{name}"
    frame["initial"] = {"Q": np.eye(3, 2), "Qdot": np.ones((3, 2))}
    with pytest.raises(stiefel.InvalidArgument, match=r"as many columns as inertia has numbers, 3; it looks transposed"):
        client.create(frame)


def test_a_scene_has_the_forms_of_body(client):
    """`order`, `mrp`, matrices, `frame`, `angular_momentum`: a dict and a file mean what stiefel.body makes of them."""
    Q = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    for forms in ({"attitude": [0, 0, 0.6, 0.8], "order": "xyzw", "angular_velocity": [1, 2, 3], "frame": "space"},
                  {"mrp": [0.1, 0.2, 0.3], "angular_momentum": [1, 2, 3]}, {"attitude": Q, "angular_momentum": [1, 2, 3], "frame": "space"}):
        scene = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], **forms}}
        assert stiefel.to_message(scene) == stiefel.to_message(stiefel.body(moments=[1, 2, 3], step=0.1, **forms))
    with pytest.raises(stiefel.InvalidArgument, match=r"scene\.body\.order: 'zyx': must be one of wxyz, xyzw"):
        stiefel.to_message({"system": "rigid_body", "body": {"order": "zyx"}})
    rounded = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "attitude": [0.7071, 0, 0, 0.7071], "angular_velocity": [1, 2, 3]}}
    with pytest.raises(stiefel.InvalidArgument, match="norm"):
        client.create(rounded)
    assert client.create({**rounded, "normalize": True}).scene["body"]["attitude"] == pytest.approx([0.5**0.5, 0, 0, 0.5**0.5])
    with pytest.raises(stiefel.InvalidArgument, match=r"scene\.normalize: 1: must be true or false"):
        client.create({**rounded, "normalize": 1})
