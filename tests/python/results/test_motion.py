"""The closed form of a free rigid body: periods and mean rates beside mpmath's integrals and the engine's exact states."""
import math

import numpy as np
import pytest

import stiefel
from stiefel._results.motion import agm, closed_form

rng = np.random.default_rng(3)
BODIES = [(np.sort(rng.uniform(1, 2, 3)), rng.normal(size=3)) for _ in range(8)]
BODIES += [(np.array([1, 2, 3.0]), np.array(m)) for m in ([0.1, 2, 0.1], [1e-6, 1, 1e-7], [1, 1e-9, 1e-9], [1e-9, 0, 1], [0.3, 1, 0.3])]
BODIES += [(np.array([1e-3, 1, 1.0005]), np.array([0.1, 1, 1])), (np.array([1, 1, 1.5]), np.array([1, 0.3, 1])),
           (np.array([1, 1.5, 1.5]), np.array([1, 0.3, 1]))]


def by_mpmath(I, m):
    """Period of the angular velocity and mean rate of the long axis, from the integrals of the textbook in 40 digits."""
    mp = pytest.importorskip("mpmath", reason="python3-mpmath is not installed")
    with mp.workdps(40):
        I1, I2, I3 = map(mp.mpf, I.tolist())
        m1, m2, m3 = map(mp.mpf, m.tolist())
        L2, E2 = m1**2 + m2**2 + m3**2, m1**2 / I1 + m2**2 / I2 + m3**2 / I3
        above, below = E2 * I3 - L2, L2 - E2 * I1
        if L2 > E2 * I2:
            k2, speed = (I2 - I1) * above / ((I3 - I2) * below), mp.sqrt((I3 - I2) * below / (I1 * I2 * I3))
            n = -I1 * above / (I3 * below)
        else:
            k2, speed = (I3 - I2) * below / ((I2 - I1) * above), mp.sqrt((I2 - I1) * above / (I1 * I2 * I3))
            n = -I1 * (I3 - I2) / (I3 * (I2 - I1))
        K = mp.ellipk(k2)
        rate = mp.sqrt(L2) / I1 * (1 - (I3 - I1) / I3 * mp.ellippi(n, k2) / K)
        return float(4 * K / speed), float(2 * mp.pi / rate), float(1 - k2), float(E2 / 2)


@pytest.mark.parametrize("I, m", BODIES)
def test_periods_are_those_of_the_integrals(I, m):
    found = closed_form(I, m, m)
    period, precession, separatrix, energy = by_mpmath(I, m)
    # Near the separatrix m decides 1 - k^2 only to its rounding, u / (1 - k^2), of which the period has the logarithm.
    bound = max(1e-12, 4e-16 / separatrix)
    assert found.period == pytest.approx(period, rel=bound) and found.nutation_period == found.period / 2
    assert found.precession_period == pytest.approx(precession, rel=bound) and found.energy == pytest.approx(energy, rel=1e-15)
    assert found.separatrix == pytest.approx(separatrix, rel=bound)


def test_the_integrals_are_those_of_scipy():
    special = pytest.importorskip("scipy.special", reason="python3-scipy is not installed")
    for k2 in (0.0, 0.3, 0.9, 1 - 1e-9):
        assert math.pi / (2 * agm(1 - k2, -0.5)[0]) == pytest.approx(special.ellipkm1(1 - k2), rel=1e-14)
        for n in (0.5, -0.3, -40.0, -1e8):
            mean, total = agm(1 - k2, n)
            Pi = special.elliprf(0, 1 - k2, 1) + n / 3 * special.elliprj(0, 1 - k2, 1, 1 - n)
            assert math.pi / (4 * mean) * (2 + n / (1 - n) * total) == pytest.approx(Pi, rel=2e-14)


@pytest.mark.parametrize("I, omega", [([1, 2, 3], [0.1, 2, 0.1]), ([1, 2, 3], [0.02, 0.3, 1]), ([3, 1, 2], [0.2, 1, 0.5]),
                                      ([2.5, 7.1, 8.3], [1, 0.2, 0.1])])
def test_the_engine_repeats_after_a_period(client, I, omega):
    """The angular velocity repeats, and the attitude has turned about L by 2 pi times period over precession period."""
    scene = {"system": "rigid_body", "step": 0.1, "body": {"moments": I, "angular_velocity": omega, "attitude": [0.5, 0.5, 0.5, 0.5]}}
    with client.create(scene) as session:
        motion = session.trajectory(to=1).motion
        run = session.trajectory(times=[0, motion.period], fields=["Q", "angular_velocity", "momentum_space"])
        assert session.scene["method"]["name"] == "exact"
    np.testing.assert_allclose(run["angular_velocity"][1], omega, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["momentum_space"], [motion.momentum] * 2, rtol=0, atol=1e-14)
    turn = run["Q"][1] @ run["Q"][0].T
    axis = motion.momentum / np.linalg.norm(motion.momentum)
    angle = 2 * np.pi * motion.period / motion.precession_period
    K = np.cross(axis, np.eye(3)).T
    np.testing.assert_allclose(turn, np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K, rtol=0, atol=1e-12)


def test_the_angle_to_the_momentum_stays_in_its_bounds(client):
    for omega, axis in (([0.02, 0.3, 1], 2), ([1, 0.2, 0.1], 0)):
        scene = {"system": "rigid_body", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": omega}}
        with client.create(scene) as session:
            motion = session.trajectory(to=1).motion
            run = session.trajectory(times=np.linspace(0, motion.period, 401), fields="M")
        m = np.stack([run["M"][:, 2, 1], run["M"][:, 0, 2], run["M"][:, 1, 0]], axis=1)
        angle = np.arccos(m[:, axis] / np.linalg.norm(m, axis=1))
        least, largest = motion.nutation
        assert motion.kind == ("short-axis mode" if axis == 2 else "long-axis mode")
        assert least - 1e-12 <= angle.min() < least + 1e-3 and largest - 1e-3 < angle.max() <= largest + 1e-12


def test_a_tensor_and_blocks_give_the_same_motion(client):
    tensor = [2.0, 3, 4, 0.1, 0.2, 0.3]
    with client.create({"system": "rigid_body", "step": 0.1, "body": {"inertia_tensor": tensor, "angular_velocity": [1, 2, 3]}}) as session:
        of_tensor = session.trajectory(to=0).motion
        assert np.allclose(session.trajectory(to=0, fields="momentum_space")["momentum_space"][0], of_tensor.momentum, atol=1e-14)
    I = np.array([1.0, 2, 3])
    M = np.array([[0, -0.2, 4], [0.2, 0, -0.1], [-4, 0.1, 0]])
    with client.create({"system": "rigid_body", "step": 0.1, "inertia": (I.sum() / 2 - I), "initial": {"Q": np.eye(3), "M": M}}) as session:
        of_blocks = session.trajectory(to=0).motion
    with client.create({"system": "rigid_body", "step": 0.1, "body": {"moments": I, "angular_velocity": [0.1, 2, 0.2 / 3]}}) as session:
        of_body = session.trajectory(to=0).motion
    assert of_blocks.period == pytest.approx(of_body.period, rel=1e-12) and np.allclose(of_blocks.momentum, of_body.momentum)


def test_special_motions_have_names():
    one = closed_form(np.ones(3), np.array([0, 3.0, 4]), np.zeros(3))
    assert one.kind == "steady rotation" and one.precession_period == pytest.approx(2 * np.pi / 5) and one.period == math.inf
    rest = closed_form(np.array([1.0, 2, 3]), np.zeros(3), np.zeros(3))
    assert rest.kind == "at rest" and rest.P_phi == math.inf and one.P_phi == one.precession_period and "at rest" in repr(rest)
    middle = closed_form(np.array([1.0, 2, 3]), np.array([0, 2.0, 0]), np.zeros(3))
    assert middle.kind == "steady rotation" and middle.separatrix == 0 and middle.precession_period == pytest.approx(2 * np.pi)
    long = closed_form(np.array([1.0, 2, 3]), np.array([1.0, 0, 0]), np.zeros(3))
    assert long.kind == "steady rotation"
    I = np.array([1.0, 2, 3])  # m1^2 (I2 - I1) / I1 = m3^2 (I3 - I2) / I3 exactly
    assert closed_form(I, np.array([1.0, 1, math.sqrt(3)]), np.zeros(3)).separatrix < 1e-15
    assert len(repr(one).splitlines()) == 3


def test_toutatis_has_the_periods_of_its_observers():
    """Ostro et al. 1999: 5.38 days about the long axis, which turns about the momentum in 7.42 days."""
    motion = stiefel.simulate("toutatis", to=1).motion
    assert motion.kind == "long-axis mode"
    assert motion.period / 86400 == pytest.approx(5.38, abs=0.05) and motion.precession_period / 86400 == pytest.approx(7.42, abs=0.1)


def test_other_scenes_have_no_closed_form(client):
    M = np.triu(np.ones((4, 4)), 1)
    for scene in ({"system": "rigid_body", "step": 0.1, "inertia": [1, 2, 3, 4], "initial": {"M": M - M.T}},
                  {"system": "moser_veselov", "step": 0.1, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 2, 3]}},
                  {"system": "rigid_body", "step": 0.1, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 2, 3]}}):
        with client.create(scene) as session, pytest.raises(ValueError, match="closed form"):
            session.trajectory(to=1).motion


def test_a_notebook_shows_a_motion_as_a_table():
    shown = closed_form(np.array([1.0, 2, 3]), np.array([0.3, 1, 0.3]), np.array([1.0, 0, 0]))._repr_html_()
    assert "<td>kind</td>" in shown and "<td>precession_period</td>" in shown and shown.count("<tr>") == 9
    assert " s, nutation " in repr(stiefel.simulate("toutatis", to=1).motion) and " J>" in repr(stiefel.simulate("toutatis", to=1).motion)
    assert " s, nutation " not in repr(stiefel.simulate({"system": "rigid_body", "inertia": [1, 2, 3], "initial": {"M": [[0, 1, 0], [-1, 0, 2], [0, -2, 0]]}, "step": 1}, to=1).motion)


@pytest.mark.parametrize("system", ["right_rigid_body", "symmetric_rigid_body", "right_symmetric_rigid_body", "reduced_rigid_body",
                                    "mclachlan_scovel", "stiefel", "stiefel_momentum", "stiefel_costate"])
def test_the_motion_does_not_depend_on_the_variables(client, system):
    Q = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    Q *= np.linalg.det(Q)
    scene = {"system": "rigid_body", "step": 0.1, "inertia": [3, 2, 1.5],
             "initial": {"Q": Q, "M": [[0, -0.2, 4], [0.2, 0, -0.1], [-4, 0.1, 0]]}}
    expected = client.create(scene).trajectory(to=0).motion
    other = client.convert(scene, system).scene
    assert other["system"] == system
    found = client.create(other).trajectory(to=0).motion
    assert found.kind == expected.kind and np.allclose(found.momentum, expected.momentum, rtol=0, atol=1e-13)
    for name in ("separatrix", "period", "precession_period", "energy"):
        assert getattr(found, name) == pytest.approx(getattr(expected, name), rel=1e-12)


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
