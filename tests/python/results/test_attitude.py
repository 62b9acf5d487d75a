"""Attitudes as rotations of scipy and as Euler angles."""
import itertools

import numpy as np
import pytest

import stiefel
from stiefel._results.attitude import angle_between, between, euler_angles, quaternions

BODY = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": [0.4, 1, 0.2]}}
RNG = np.random.default_rng(1)
Q = [q / np.linalg.norm(q) for q in RNG.normal(size=(200, 4))]


def matrix(q):
    w, v = q[0], q[1:]
    K = np.cross(v, np.eye(3)).T
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * K


def turn(axis, angle):
    return matrix(np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.eye(3)["xyz".index(axis)])]))


@pytest.mark.parametrize("sequence", ["".join(s) for s in itertools.product("xyz", repeat=3) if s[0] != s[1] != s[2]])
def test_euler_angles_give_the_attitude_again(sequence):
    proper = sequence[0] == sequence[2]
    special = [m @ turn(sequence[1], a) for m in map(matrix, Q[:5]) for a in (0,)]
    for turning in (True, False):
        order = sequence.upper() if turning else sequence
        for q in Q + [quaternions({"Q": turn(sequence[0], 0.3) @ turn(sequence[1], middle) @ turn(sequence[2], 0.5)})
                      for middle in ((0, np.pi) if proper else (np.pi / 2, -np.pi / 2))]:
            angles = euler_angles({"quaternion": q}, order)
            parts = [turn(axis, angle) for axis, angle in zip(sequence, angles)]
            product = parts[0] @ parts[1] @ parts[2] if turning else parts[2] @ parts[1] @ parts[0]
            np.testing.assert_allclose(product, matrix(q), atol=3e-8)  # where an angle is lost: its square root of rounding
            assert (0 if proper else -np.pi / 2) - 1e-12 <= angles[1] <= (np.pi if proper else np.pi / 2) + 1e-12
        for q in Q:
            parts = [turn(axis, angle) for axis, angle in zip(sequence, euler_angles({"quaternion": q}, order))]
            product = parts[0] @ parts[1] @ parts[2] if turning else parts[2] @ parts[1] @ parts[0]
            np.testing.assert_allclose(product, matrix(q), atol=1e-14)
    assert len(special) == 5


def test_a_matrix_and_its_quaternion_are_one_attitude():
    found = quaternions({"Q": np.array([matrix(q) for q in Q])})
    assert angle_between(found, np.array(Q)).max() < 1e-15 * 4
    with pytest.raises(ValueError, match="determinant is -1"):
        quaternions({"Q": -np.eye(3)})
    with pytest.raises(ValueError, match="needs the field quaternion"):
        quaternions({"M": np.eye(3)})


def test_halfway_lies_between():
    first, second = np.array([1.0, 0, 0, 0]), np.array([np.cos(0.3), 0, 0, np.sin(0.3)])
    assert between(first, -second, np.array(0.25))[3] == pytest.approx(np.sin(0.075), abs=1e-16)
    assert angle_between(between(first, first, np.array(0.5)), first) == 0


def test_rotations_of_scipy(client):
    transform = pytest.importorskip("scipy.spatial.transform", reason="python3-scipy is not installed")
    with client.create(BODY) as session:
        run = session.trajectory(to=30, fields=["quaternion", "Q", "angular_velocity", "angular_velocity_space"])
        state, only_Q = session.step(to=30), session.trajectory(to=30, fields="Q")
    rotation = run.as_rotation()
    np.testing.assert_allclose(rotation.as_matrix(), run["Q"], atol=1e-15)
    np.testing.assert_allclose(rotation.apply(run["angular_velocity"]), run["angular_velocity_space"], atol=1e-14)
    assert (state.as_rotation().inv() * only_Q.as_rotation()[-1]).magnitude() < 1e-15
    for sequence in ("ZXZ", "zyx", "ZYX"):
        np.testing.assert_allclose(run.euler_angles(sequence), rotation.as_euler(sequence), atol=1e-13)
        assert np.allclose(only_Q.euler_angles(sequence, degrees=True), rotation.as_euler(sequence, degrees=True), atol=1e-11)
    assert isinstance(stiefel.simulate("toutatis", time=86400).as_rotation()[-1], transform.Rotation)
    with client.create({**BODY, "members": 2}) as session, pytest.raises(ValueError, match="of one member"):
        session.trajectory(to=1).as_rotation()


@pytest.mark.parametrize("sequence", ["", "zz", "zzx", "Zxz", "abc", "zxzx", "321"])
def test_another_sequence_is_refused(sequence):
    with pytest.raises(ValueError, match="sequence: .*3-2-1 of a body's axes is ZYX"):
        euler_angles({"quaternion": Q[0]}, sequence)


@pytest.mark.parametrize("system", ["rigid_body", "right_rigid_body", "symmetric_rigid_body", "right_symmetric_rigid_body"])
def test_the_attitude_takes_body_axes_to_space_axes_in_every_system(client, system, tmp_path):
    """The momentum in space, R I omega, is constant where R takes body axes to space axes. In the right-invariant systems Q
    takes space to body, and Q' = Omega Q."""
    transform = pytest.importorskip("scipy.spatial.transform")
    right = system.startswith("right")
    inertia, I = np.array([2.5, 1.5, 0.5]), np.array([2.0, 3.0, 4.0])
    start = transform.Rotation.from_euler("ZXZ", [0.3, 1.1, -0.4])
    omega = np.array([0.4, 1.0, 0.2])
    hat = np.cross(np.eye(3), omega)  # hat v = omega x v
    Q, Omega = start.as_matrix(), hat
    scene = {"system": system, "step": 0.1, "inertia": inertia,
             "initial": {"Q": Q.T if right else Q, "Omega": -Omega if right else Omega}, "epoch": "2026-01-01T00:00:00Z"}
    with client.create(scene) as session:
        run = session.trajectory(to=40, fields=["Q", "Omega"])
        batch = next(session.stream(to=40, fields=["Q"]))
        with session.drive("Q") as drive:
            states = [session.step(to=40, fields="Q"), session.step(time=4.0, fields="Q"), batch[40], run[40], run[::2][20], drive.step(40)]
    R = run.as_rotation()
    velocity = np.stack([run["Omega"][:, 2, 1], run["Omega"][:, 0, 2], run["Omega"][:, 1, 0]], axis=1) * (-1 if right else 1)
    assert (R[0] * start.inv()).magnitude() < 1e-15 and np.allclose(velocity[0], omega, rtol=0, atol=1e-15)
    assert np.ptp(R.apply(I * velocity), axis=0).max() < 1e-13
    for state in states:
        assert (state.as_rotation() * R[40].inv()).magnitude() < 1e-14
    assert np.allclose(run.euler_angles("ZXZ"), R.as_euler("ZXZ"), rtol=0, atol=1e-13)
    run.save(tmp_path / "run.npz")
    assert (stiefel.load(tmp_path / "run.npz").as_rotation() * R.inv()).magnitude().max() < 1e-15
    run.to_aem(tmp_path / "run.aem")
    lines = [line.split() for line in (tmp_path / "run.aem").read_text().splitlines() if line.startswith("2026-")]
    found = transform.Rotation.from_quat(np.array([line[1:5] for line in lines], float))  # x, y, z, w: of space into body
    assert (found * R.inv()).magnitude().max() < 1e-9


def test_a_matrix_that_is_no_rotation_has_no_attitude():
    with pytest.raises(ValueError, match="its rows are not orthonormal"):
        quaternions({"Q": 1.1 * np.eye(3)})
