"""Attitudes as rotations and Euler angles of SciPy, and states at any times of a run."""
import itertools

import numpy as np
import pytest

import stiefel

transform = pytest.importorskip("scipy.spatial.transform", reason="python3-scipy is not installed")
BODY = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": [0.4, 1, 0.2], "attitude": [0.5, 0.5, 0.1, 0.7]}}
SEQUENCES = ["".join(s) for s in itertools.product("xyz", repeat=3) if s[0] != s[1] != s[2]]
STATUS = stiefel.RunStatus(stiefel.Outcome.REACHED)


def test_rotations_and_euler_angles_are_those_of_scipy(client):
    with client.create(BODY) as session:
        run = session.trajectory(to=300, fields=["quaternion", "Q", "angular_velocity", "angular_velocity_space"])
        state, only_Q = session.step(to=30), session.trajectory(to=300, fields="Q")
    rotation = run.as_rotation()
    np.testing.assert_allclose(rotation.as_matrix(), run["Q"], atol=2e-15)
    np.testing.assert_allclose(rotation.apply(run["angular_velocity"]), run["angular_velocity_space"], atol=1e-14)
    assert (state.as_rotation().inv() * only_Q.as_rotation()[30]).magnitude() < 1e-15
    for sequence in ("ZXZ", "zyx"):
        wrapped, angles = rotation.as_euler(sequence), run.euler_angles(sequence)
        assert np.allclose(run.euler_angles(sequence, unwrap=False), wrapped, rtol=0, atol=1e-14)
        assert np.abs(np.diff(angles, axis=0)).max() < np.pi and np.ptp(angles) > 2 * np.pi
        np.testing.assert_allclose((angles - wrapped) / (2 * np.pi), np.rint((angles - wrapped) / (2 * np.pi)), atol=1e-14)
        assert np.allclose(only_Q.euler_angles(sequence, degrees=True), np.degrees(angles), rtol=0, atol=1e-11)
    with pytest.raises(ValueError, match="sequence: 'Zxz': .*3-2-1 of a body's axes is ZYX"):
        run.euler_angles("Zxz")
    with client.create({**BODY, "members": 2}) as session, pytest.raises(ValueError, match="of one member"):
        session.trajectory(to=1).as_rotation()


@pytest.mark.parametrize("sequence", [*SEQUENCES, *map(str.upper, SEQUENCES)])
def test_rates_are_the_derivatives_of_the_angles(sequence):
    """Of angles that are known functions of time. omega in the body is half of what turns the quaternion, 2 q* q'."""
    t, h = np.linspace(0, 3, 7), 1e-4

    def angles(t):
        middle = 0.7 * np.sin(t) + (1.4 if sequence[0] == sequence[2] else 0.2)
        return np.stack([2 * t, middle, 1 - t + 0.3 * t**2], axis=-1)

    R = [transform.Rotation.from_euler(sequence, angles(t + k * h)) for k in (-1, 0, 1)]
    omega = (R[0].inv() * R[2]).as_rotvec() / (2 * h)
    run = stiefel.Trajectory(np.arange(7), t, {"quaternion": np.roll(R[1].as_quat(), 1, axis=-1), "angular_velocity": omega}, STATUS,
                             origin=stiefel.simulate(BODY, to=0).origin)
    rates = np.stack([np.full(7, 2.0), 0.7 * np.cos(t), -1 + 0.6 * t], axis=-1)
    np.testing.assert_allclose(run.euler_rates(sequence), rates, atol=1e-6)
    np.testing.assert_allclose(run.euler_rates(sequence, degrees=True), np.degrees(rates), atol=1e-4)


@pytest.mark.parametrize("system", ["rigid_body", "right_rigid_body", "symmetric_rigid_body", "right_symmetric_rigid_body"])
def test_the_attitude_takes_body_axes_to_space_axes_in_every_system(client, system, tmp_path):
    """The momentum in space, R I omega, is constant where R takes body axes to space axes. In the right-invariant systems Q
    takes space to body, and Q' = Omega Q."""
    right = system.startswith("right")
    inertia, I = np.array([2.5, 1.5, 0.5]), np.array([2.0, 3.0, 4.0])
    start = transform.Rotation.from_euler("ZXZ", [0.3, 1.1, -0.4])
    omega = np.array([0.4, 1.0, 0.2])
    hat = np.cross(np.eye(3), omega)  # hat v = omega x v
    Q, Omega = start.as_matrix(), hat
    scene = {"system": system, "step": 0.1, "inertia": inertia,
             "initial": {"Q": Q.T if right else Q, "Omega": -Omega if right else Omega}, "epoch": "2026-01-01T00:00:00Z"}
    with client.create(scene) as session:
        run = session.trajectory(to=40, fields=["Q", "Omega", "M"])
        batch = next(session.stream(to=40, fields=["Q"]))
        with session.drive("Q") as drive:
            states = [session.step(to=40, fields="Q"), session.step(time=4.0, fields="Q"), batch[40], run[40], run[::2][20], drive.step(40), run.at(4.0)]
    R = run.as_rotation()
    velocity = np.stack([run["Omega"][:, 2, 1], run["Omega"][:, 0, 2], run["Omega"][:, 1, 0]], axis=1) * (-1 if right else 1)
    assert (R[0] * start.inv()).magnitude() < 1e-15 and np.allclose(velocity[0], omega, rtol=0, atol=1e-15)
    assert np.ptp(R.apply(I * velocity), axis=0).max() < 1e-13
    angles, rates = run.euler_angles("ZXZ"), run.euler_rates("ZXZ")
    np.testing.assert_allclose(rates[:, 0] * np.cos(angles[:, 1]) + rates[:, 2], velocity[:, 2], atol=1e-13)
    for state in states:
        assert (state.as_rotation() * R[40].inv()).magnitude() < 1e-14
    run.save(tmp_path / "run.npz")
    assert (stiefel.load(tmp_path / "run.npz").as_rotation() * R.inv()).magnitude().max() < 1e-15
    written = run.to_aem(tmp_path / "run.aem")
    lines = [line.split() for line in (tmp_path / "run.aem").read_text().splitlines() if line.startswith("2026-")]
    found = transform.Rotation.from_quat(np.array([line[1:5] for line in lines], float))  # x, y, z, w: of space into body
    assert written.samples == 41 and (found * R.inv()).magnitude().max() < 1e-9


@pytest.mark.parametrize("Q, said", [(-np.eye(3), "determinant is -1"), (1.1 * np.eye(3), "its rows are not orthonormal"), (np.eye(4), "needs the field quaternion")])
def test_a_matrix_that_is_no_rotation_has_no_attitude(Q, said):
    with pytest.raises(ValueError, match=said):
        stiefel.Trajectory(np.arange(1), np.zeros(1), {"Q": Q[None]}, STATUS).as_rotation()


def test_a_state_at_any_time_is_that_of_a_run_at_this_time(client):
    epoch = {**BODY, "epoch": "2026-03-01T12:00:00 UTC", "method": {"name": "variational"}}
    with client.create(epoch) as session:
        run = session.trajectory(to=40, every=10, fields=["Q", "M"])
        expected = session.trajectory(times=[0.0, 1.234, 4.0], fields=["Q", "M"])
    assert run.at([0.0, 1.234, 4.0]) == expected and run.at(1.234) == expected[1] and run.at(np.float64(4)).step == 40
    assert run.at("2026-03-01T12:00:04 UTC") == expected[2]
    assert (run.status, run.success, run.message) == (0, True, "The run reached its end.")
    with client.create({**BODY, "members": 2}) as session:
        assert session.trajectory(to=5).at(0.25)["quaternion"].shape == (2, 4)
    for wrong, said in ((4.001, "t: 4.001: must be a time, or several, from 0.0 to 4.0"), ([0, -1], "t: -1.0"), ([[1]], "t: "), ([], "t: "), ("noon", "t: ")):
        with pytest.raises(stiefel.InvalidArgument, match=said):
            run.at(wrong)
    stopped = stiefel.simulate({**BODY, "step": 5.0, "method": {"name": "variational"}}, to=3)
    assert (stopped.status, stopped.success) == (-1, False) and stopped.message == stopped.run_status.message != ""
