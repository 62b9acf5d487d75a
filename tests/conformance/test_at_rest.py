"""A body at rest, or almost at rest, has no drift: the scale of an invariant is at least its rounding error.

At rest, a momentum that is a difference of frames, Q^T P - P^T Q, is 1e-16 instead of 0, and its energy 1e-33. Such a
number must not be the scale: 2e-33 in the next state is not a drift of 100 %.
"""
import math

import numpy as np
import pytest


RANDOM = np.random.default_rng(11)
INERTIA = [1.0, 2.0, 3.0, 2.5]


def rotation(n):
    Q = np.linalg.qr(RANDOM.standard_normal((n, n)))[0]
    Q[0] *= np.linalg.det(Q)
    return Q


def symmetric(n):
    A = RANDOM.standard_normal((n, n))
    return A @ A.T


Q = rotation(4)
F, q = Q[:2], Q[:1]
SKEW = RANDOM.standard_normal((4, 4))
SKEW -= SKEW.T


def scene(system, initial, method=None, **more):
    made = {"system": system, "inertia": INERTIA, "initial": initial, "step": 0.1, **more}
    return {**made, "method": {"name": method}} if method else made


def in_GL(system, mu, h):
    """Returns a scene with Q^-1 P - P^-1 Q = mu Lambda^2, so that M = 0."""
    W = mu * np.diag(np.square(INERTIA)) / 2
    A = np.eye(4) + 0.3 * RANDOM.standard_normal((4, 4))
    P = A @ (W + np.sqrt(np.eye(4) + W * W))
    return scene(system, {"Q": A, "P": P}, parameter=mu, method="rk4" if system == "parametric_rigid_body" else None)


def bodies(M):
    for method in ("variational", "rk4", "munthe_kaas4", "implicit_midpoint", "adaptive"):
        yield f"rigid_body {method}", scene("rigid_body", {"Q": Q, "M": M}, method)
    for method in ("variational", "exact", "splitting", "preprocessed_variational", "adaptive"):
        yield f"rigid_body 3 {method}", scene("rigid_body", {"Q": rotation(3), "M": M[:3, :3]}, method,
                                              inertia=INERTIA[:3])
    yield "moser_veselov", scene("moser_veselov", {"Q": Q, "M": M})
    for system in ("right_rigid_body", "mclachlan_scovel", "symmetric_rigid_body", "right_symmetric_rigid_body",
                   "reduced_rigid_body"):
        yield system, scene(system, {"Q": Q, "M": M}, "rk4")
    yield "symmetric_moser_veselov", scene("symmetric_moser_veselov", {"Q": Q, "M": M})


def frames(S):
    for method in ("variational", "rk4", "adaptive"):
        yield f"stiefel {method}", scene("stiefel", {"Q": F, "S": S[:2]}, method)
    yield "ellipsoid", scene("ellipsoid", {"q": q, "qdot": S[:1] / INERTIA}, "variational")


def at_rest():
    yield from bodies(np.zeros((4, 4)))
    yield from frames(np.zeros((4, 4)))
    yield "body", {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.1, "body": {
        "inertia_tensor": [2, 3, 4, 0.1, 0.2, 0.3], "angular_velocity": [0, 0, 0]}}
    for epsilon in (1.0, -1e-3, 1e6):
        for system in ("symmetric_rigid_body", "reduced_rigid_body", "right_symmetric_rigid_body"):
            S = symmetric(4)
            P = S @ Q if system.startswith("right") else Q @ S  # Q^T P, or P Q^T, is symmetric
            yield f"{system} epsilon {epsilon}", scene(system, {"Q": Q, "P": P}, "munthe_kaas4", epsilon=epsilon)
    yield "symmetric_moser_veselov P", scene("symmetric_moser_veselov", {"Q": Q, "P": Q @ symmetric(4)})
    for i, step in enumerate((0.1, 1e-6)):
        yield f"moser_veselov_pair {i}", scene("moser_veselov_pair", {"Q_prev": Q, "Q": Q}, step=step)
        yield f"discrete_stiefel {i}", scene("discrete_stiefel", {"Q_prev": F, "Q": F}, step=step)
    for mu in (0.0, 0.05):
        yield f"parametric_rigid_body {mu}", in_GL("parametric_rigid_body", mu, 1)
        yield f"parametric_moser_veselov {mu}", in_GL("parametric_moser_veselov", mu, 0.1)
    for size in (0.0, 1.0, 1e3):
        yield f"stiefel_costate {size}", scene("stiefel_costate", {"Q": F, "P": size * symmetric(2) @ F}, "rk4")
    yield "stiefel_momentum", scene("stiefel_momentum", {"Q": F, "M": np.zeros((4, 4))}, "rk4")
    yield "ellipsoid p", scene("ellipsoid", {"q": q, "p": 3.3 * q}, "rk4")
    A = RANDOM.standard_normal((2, 3)) + 1j * RANDOM.standard_normal((2, 3))
    for name, P in (("0", 0 * A), ("Q", 0.7 * A), ("-Q", -A)):
        yield f"double_bracket {name}", {"system": "double_bracket", "inertia_u": [1, 2], "inertia_v": [1, 2, 3],
                                         "initial": {"Q": A, "P": P}, "step": 0.1, "method": {"name": "munthe_kaas4"}}


def hardly_moving():
    for size in (1e-100, 1e-300):
        yield from ((f"{name} {size}", scene) for name, scene in bodies(size * SKEW))
        U = size * SKEW
        S = np.vstack([F, Q[2:]]) @ U * INERTIA
        yield from ((f"{name} {size}", scene) for name, scene in frames(S))


CASES = {**dict(at_rest()), **dict(hardly_moving())}


@pytest.mark.parametrize("name", CASES)
def test_drift_is_rounding(client, name):
    steps = 20 if name.startswith("parametric") else 100  # parametric states grow like e^(mu lambda t)
    with client.create(CASES[name]) as session:
        diagnosis = session.diagnose(steps)
    assert diagnosis.run_status.message == "" and diagnosis.invariants
    for invariant in diagnosis.invariants:
        assert math.isfinite(invariant.scale) and invariant.scale >= 0
        assert invariant.drift < 1e-12, (invariant.name, invariant.initial, invariant.value, invariant.scale)


def test_what_is_resolved_keeps_its_own_scale(client):
    """The scale of a motion well above the rounding of P is its own, so that the digits that it loses with epsilon = 1
    are not hidden."""
    M = 1e-10 * SKEW
    scene_of = lambda system: scene(system, {"Q": Q, "M": M}, "rk4", **({"epsilon": 1.0} if "symm" in system else {}))
    scales = []
    for system in ("rigid_body", "symmetric_rigid_body"):
        with client.create(scene_of(system)) as session:
            scales.append({i.name: i.scale for i in session.diagnose(0).invariants})
    for name, scale in scales[0].items():
        assert scales[1][name] == pytest.approx(scale, rel=1e-4), name


@pytest.mark.parametrize("step", (0.125, 1e-6))
def test_a_slow_frame_stays_and_keeps_its_own_scale(client, step):
    """In 1000 steps a frame with S ~ 1e-30 moves by 1e-28, and S changes by 1e-28 of itself."""
    S = 1e-30 * (F @ SKEW * INERTIA)
    with client.create(scene("stiefel", {"Q": F, "S": S}, "variational", step=step)) as session:
        state, diagnosis = session.step(to=1000), session.diagnose(1000)
    np.testing.assert_allclose(state["S"], S, rtol=0, atol=1e-14 * np.abs(S).max())
    invariants = {i.name: i for i in diagnosis.invariants}
    assert invariants["energy"].scale == pytest.approx(np.sum(S * S / INERTIA) / 2)
    assert invariants["spatial_momentum[0,1]"].scale == pytest.approx(np.linalg.norm(S))
    assert all(i.drift < 1e-14 for i in invariants.values())


def test_the_trade_off_of_a_body_at_rest_reports_no_drift(client):
    made = scene("symmetric_rigid_body", {"Q": Q, "P": Q @ symmetric(4)}, epsilon=1.0)
    points = client.tradeoff(made, horizon=1.0, budget=1e7).points
    assert points and all(point.drift < 1e-10 for point in points)
