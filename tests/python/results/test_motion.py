"""The closed form of a free rigid body, which the server has: its periods are those of the states."""
import math

import numpy as np
import pytest

import stiefel


@pytest.mark.parametrize("I, omega", [([1, 2, 3], [0.1, 2, 0.1]), ([1, 2, 3], [0.02, 0.3, 1]), ([3, 1, 2], [0.2, 1, 0.5]), ([2.5, 7.1, 8.3], [1, 0.2, 0.1])])
def test_the_motion_repeats_after_a_period(client, I, omega):
    """The angular velocity repeats, and the attitude has turned about L by 2 pi times period over precession period."""
    scene = {"system": "rigid_body", "step": 0.1, "body": {"moments": I, "angular_velocity": omega, "attitude": [0.5, 0.5, 0.5, 0.5]}}
    with client.create(scene) as session:
        found = session.trajectory(to=1).motion
        run = session.trajectory(times=np.linspace(0, found.period, 401), fields=["Q", "angular_velocity", "momentum_space"])
    np.testing.assert_allclose(run["angular_velocity"][400], omega, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["momentum_space"], np.broadcast_to(found.momentum, (401, 3)), rtol=0, atol=1e-13)
    axis, angle = found.momentum / np.linalg.norm(found.momentum), 2 * np.pi * found.period / found.precession_period
    K = np.cross(axis, np.eye(3)).T
    np.testing.assert_allclose(run["Q"][400] @ run["Q"][0].T, np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K, rtol=0, atol=1e-12)
    momenta = run["angular_velocity"] * I
    nutation = np.arccos(abs(momenta[:, np.argsort(I)[2 if found.kind == "short-axis mode" else 0]]) / np.linalg.norm(momenta, axis=1))
    assert found.nutation[0] - 1e-9 <= nutation.min() < found.nutation[0] + 1e-3 and found.nutation[1] - 1e-3 < nutation.max() <= found.nutation[1] + 1e-9
    assert found.nutation_period == found.period / 2 and np.allclose(found.axes @ np.diag(found.moments) @ found.axes.T, np.diag(I))


def test_special_motions_have_names():
    def motion(moments, omega):
        return stiefel.simulate({"system": "rigid_body", "step": 0.1, "body": {"moments": moments, "angular_velocity": omega}}, to=0).motion

    ball, rest, middle, long = motion([1, 1, 1], [0, 3, 4]), motion([1, 2, 3], [0, 0, 0]), motion([1, 2, 3], [0, 1, 0]), motion([1, 2, 3], [1, 0, 0])
    assert [one.kind for one in (ball, rest, middle, long)] == ["steady rotation", "at rest", "steady rotation", "steady rotation"]
    assert ball.precession_period == pytest.approx(2 * np.pi / 5) and ball.period == math.inf and ball.P_phi == ball.precession_period
    assert rest.P_phi == math.inf and middle.separatrix == 0 and middle.precession_period == pytest.approx(2 * np.pi)
    assert len(repr(ball).splitlines()) == 3 and " s, nutation " in repr(ball) and " J>" in repr(ball) and "<td>precession_period</td>" in ball._repr_html_()


def test_toutatis_has_the_periods_of_its_observers():
    """Ostro et al. 1999: 5.38 days about the long axis, which turns about the momentum in 7.42 days."""
    run = stiefel.simulate("toutatis", to=1)
    motion = run.motion
    assert motion.kind == "long-axis mode" and (motion.P_psi, motion.P_phi) == (motion.period, motion.precession_period)
    assert motion.period / 86400 == pytest.approx(5.38, abs=0.05) and motion.precession_period / 86400 == pytest.approx(7.42, abs=0.1)
    with run.origin.session(run.scene) as session:
        assert session.diagnose(to=7).motion == motion


def test_other_scenes_have_no_closed_form(client):
    M = np.triu(np.ones((4, 4)), 1)
    for scene in ({"system": "rigid_body", "step": 0.1, "inertia": [1, 2, 3, 4], "initial": {"M": M - M.T}},
                  {"system": "moser_veselov", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 2, 3]}},
                  {"system": "rigid_body", "step": 0.1, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 2, 3]}}):
        with client.create(scene) as session, pytest.raises(ValueError, match="closed form"):
            session.trajectory(to=1).motion


@pytest.mark.parametrize("form", ["body", "blocks"])
def test_a_member_of_an_ensemble_is_what_it_is_alone(client, form, tmp_path):
    """Its motion, its samples to the last bit, and what its file says of it."""
    spins = np.array([[0.01, 1, 0.01], [0.3, 1, 0.2], [0.02, 0.3, 1]])
    I = np.array([[1.0, 2, 3]] * 3) * [[1], [1], [2]]
    if form == "body":
        scene = {"system": "rigid_body", "step": 0.1, "members": 3, "body": {"moments": I, "angular_velocity": spins}}
    else:
        hats = np.cross((I * spins)[:, None], np.eye(3)).swapaxes(1, 2)
        scene = {"system": "symmetric_rigid_body", "step": 0.1, "members": 3, "inertia": [2, 1, 0.5],
                 "initial": {"Q": np.stack([np.eye(3)] * 3), "M": hats}}
    run = client.create(scene).trajectory(to=50, every=10)
    for member in range(3):
        one = run.member(member)
        assert "members" not in one.scene and one.scene["method"] == run.scene["method"]
        alone = client.create(one.scene).trajectory(to=50, every=10)
        assert one == alone and one.motion == alone.motion and one.run_status == alone.run_status
    one.save(tmp_path / "one.npz")
    assert stiefel.rerun(tmp_path / "one.npz") == one
    assert run.member(-1).motion.kind == "short-axis mode" and run.member(0).motion.separatrix < 1e-3
    with pytest.raises(IndexError):
        run.member(3)
    with pytest.raises(ValueError, match="single motion"):
        one.member(0)


def test_a_member_that_stops_is_told_from_the_others(client):
    scene = {"system": "moser_veselov", "step": 0.5, "members": 2,
             "body": {"moments": [1, 2, 3], "angular_velocity": [[0.1, 0.3, 0.1], [0.3, 3, 2]]}}
    run = client.create(scene).trajectory(to=20)
    assert run.run_status.member == 1
    assert run.member(0).outcome is stiefel.Outcome.REACHED and run.member(1).outcome is run.outcome
    assert run.member(1).run_status.member is None and np.isfinite(run.member(0)["quaternion"]).all()
