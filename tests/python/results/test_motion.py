"""The closed form of a free rigid body, which the server has: its periods are those of the states."""
import numpy as np
import pytest

import stiefel


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


def test_a_member_of_an_ensemble_is_what_it_is_alone(client, tmp_path):
    """Its motion, its samples to the last bit, and what its file says of it."""
    spins = np.array([[0.01, 1, 0.01], [0.3, 1, 0.2], [0.02, 0.3, 1]])
    I = np.array([[1.0, 2, 3]] * 3) * [[1], [1], [2]]
    scene = {"system": "rigid_body", "step": 0.1, "members": 3, "body": {"moments": I, "angular_velocity": spins}}
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
