"""The study of integrability: its proof's formulas against the engine, its verdicts on controls, and its bytes."""
import multiprocessing
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import stiefel

sys.path.insert(0, str(Path(__file__).parents[3] / "docs"))
import integrability  # noqa: E402

TRIPLES = [(1, 2, 4), (2, 1, 4), (4, 1, 2), (1, 5, 10), (3, 1, 0.5)]


def normal_equation(phi, a, b, c):
    """The matrix of (theta, pi)' along the geodesic that turns a row in the plane of a and b, in the angle phi."""
    x, slope = a * np.cos(phi)**2 + b * np.sin(phi)**2, (b - a) * np.sin(2 * phi)
    D = a * b + c * x
    return np.array([[-slope * (c - x) / (2 * D), 1 + slope**2 / (4 * D)],
                     [-(c - x)**2 / D - (2 * x - c) / x, -slope / (2 * x) + slope * (c - x) / (2 * D)]])


def half_turn(a, b, c, steps=2000):
    """The monodromy of half a turn, by the method of Runge and Kutta."""
    Y, h = np.eye(2), np.pi / steps
    for phi in h * np.arange(steps):
        first, middle, last = (normal_equation(phi + part * h, a, b, c) for part in (0, 0.5, 1))
        k1 = first @ Y
        k2 = middle @ (Y + h / 2 * k1)
        k3 = middle @ (Y + h / 2 * k2)
        Y = Y + h / 6 * (k1 + 2 * k2 + 2 * k3 + last @ (Y + h * k3))
    return Y


def turning_row(others, inertia):
    """The closed geodesic whose first row turns in the plane of the first two axes while the others rest at `others`."""
    inertia = np.array(inertia, float)
    nodes, weights = np.polynomial.legendre.leggauss(300)
    phi = (nodes + 1) * np.pi / 2
    half = np.sum(weights * np.pi / 2 * np.sqrt(inertia[0] * np.sin(phi)**2 + inertia[1] * np.cos(phi)**2)) / np.sqrt(inertia[1])
    axes = np.eye(len(inertia))
    Q, V = axes[[0, *others]], np.zeros((1 + len(others), len(inertia)))
    V[0, 1] = 1
    return {"system": "stiefel", "inertia": inertia.tolist(), "step": half / 200, "method": {"name": "variational", "order": 8},
            "initial": {"Q": Q, "Qdot": V}}


def monodromy(client, scene):
    """The derivative of half a turn followed by the isometry that turns the plane of the first two axes by pi."""
    with client.create(scene) as session:
        moved = session.linearize(to=200)
    back = np.where(np.arange(moved.basis.shape[2]) < 2, -1.0, 1.0)
    return np.einsum("iab,jab->ij", moved.start_basis, moved.basis * back) @ moved.matrix


@pytest.mark.parametrize("triple", TRIPLES)
def test_the_normal_equation_is_that_of_the_engine_s_tangent(client, triple):
    """Energy, flow, momentum and its symmetry give four eigenvalues 1; the other two are those of the normal equation."""
    Y, Phi = half_turn(*triple), monodromy(client, turning_row([2], triple))
    assert np.linalg.det(Y) == pytest.approx(1, abs=1e-10)
    assert np.trace(Phi) - 4 == pytest.approx(np.trace(Y), abs=1e-10 * max(1, abs(np.trace(Y))))


def test_v_2_3_is_totally_geodesic_in_larger_manifolds(client):
    """The pair of eigenvalues is found again in V(3, 5), for each axis at which a second row may rest."""
    inertia = [1, 5, 10, 3, 2]
    found = np.linalg.eigvals(monodromy(client, turning_row([2, 3], inertia)))
    for c in (10, 3):
        for value in np.linalg.eigvals(half_turn(1, 5, c)):
            assert abs(found - value).min() < 1e-9 * max(1, abs(value)), c


def coefficients(x, a, b, c):
    """p, q and q's numerator of theta'' + p theta' + q theta = 0 in x, as the page prints them."""
    s, D = a + b + c, a * b + c * x
    p = c / D - 1 / (x - s) + (1 / (x - a) + 1 / (x - b) - 1 / x) / 2
    N = (a * b * c * s + x * (a * b * (a + b) - c * (a * a + b * b) - c * c * (a + b) - 4 * a * b * c)
         + x * x * (a * b + 3 * c * (a + b)))
    return p, N / (4 * x * (x - a) * (x - b) * D * (x - s)), N


def test_the_equation_in_x_is_the_equation_in_the_angle():
    """theta'' of the first-order system by the chain rule, at random points: x = a cos^2 + b sin^2."""
    for a, b, c in TRIPLES:
        for phi in np.random.default_rng(0).uniform(0.1, 1.4, 5):
            x, slope, h = a * np.cos(phi)**2 + b * np.sin(phi)**2, (b - a) * np.sin(2 * phi), 1e-5
            A, dA = normal_equation(phi, a, b, c), (normal_equation(phi + h, a, b, c) - normal_equation(phi - h, a, b, c)) / (2 * h)
            # theta'' = first theta' + zeroth theta in phi
            first = A[0, 0] + A[1, 1] + dA[0, 1] / A[0, 1]
            zeroth = dA[0, 0] - A[0, 0] * A[1, 1] + A[0, 1] * A[1, 0] - A[0, 0] * dA[0, 1] / A[0, 1]
            p, q, _ = coefficients(x, a, b, c)
            curvature = 2 * (b - a) * np.cos(2 * phi)
            # theta_phiphi = slope^2 theta_xx + curvature theta_x
            assert first * slope - curvature == pytest.approx(-p * slope**2, rel=1e-6, abs=1e-6)
            assert zeroth == pytest.approx(-q * slope**2, rel=1e-6, abs=1e-6)


def monodromies(a, b, c, nodes=2000):
    """The monodromy of (theta, dtheta/dx) around -ab/c, 0, a, b and s, from a base point above the real line."""
    def slope(x):
        p, q, _ = coefficients(x, a, b, c)
        return np.array([[0, 1], [-q, -p]])

    points = [-a * b / c, 0, a, b, a + b + c]
    for point in points:
        top = point + 1j * min(abs(point - other) for other in points if other != point) / 3
        there = np.linspace(1 + 3j, top, nodes)
        path = [*there, *(point + (top - point) * np.exp(2j * np.pi * np.linspace(0, 1, nodes))), *there[::-1]]
        Y = np.eye(2, dtype=complex)
        for x, h in zip(path, np.diff(path)):
            k1 = slope(x) @ Y
            k2 = slope(x + h / 2) @ (Y + h / 2 * k1)
            k3 = slope(x + h / 2) @ (Y + h / 2 * k2)
            Y = Y + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + h) @ (Y + h * k3))
        yield Y


@pytest.mark.parametrize("triple", [*TRIPLES, (1, 3, 3), (3, 1, 3)])
def test_the_monodromies_share_a_line_only_if_two_numbers_are_equal(triple):
    """That of -ab/c is unipotent and has one invariant line; those of 0, a and b leave it only where c is a or b."""
    U, *others, apparent = monodromies(*triple)
    np.testing.assert_allclose([np.trace(U), np.linalg.det(U)], [2, 1], atol=1e-9)
    assert np.linalg.norm(U - np.eye(2)) > 1 and np.linalg.norm(apparent - np.eye(2)) < 1e-9
    line = np.linalg.svd(U - np.eye(2))[2][1].conj()
    moved = [abs(np.linalg.det(np.stack([line, other @ line]))) for other in others]
    assert max(moved) < 1e-9 if len(set(triple)) < 3 else min(moved) > 1e-3, moved


CONTROLS = [("sphere n=1", "regular"), ("body n=N", "regular"), ("round", "regular"), ("V(2,3) two values", "regular"),
            ("reduced (8.2)", "regular"), ("chaotic control", "chaotic")]


@pytest.mark.parametrize("group, verdict", [pytest.param(*one, marks=pytest.mark.long) if one in CONTROLS[1:] else one for one in CONTROLS])
def test_controls_are_judged_rightly(group, verdict):
    tasks = [task for task in integrability.tasks(100, 100_000, 3) if task["group"] == group][:4]
    found = [row["verdict"] for row in integrability.study(tasks)]
    assert set(found) <= {verdict, "undecided"} and found.count("undecided") <= len(found) / 4


def test_the_bytes_do_not_depend_on_who_computes():
    work = integrability.tasks(100, 4000, 1)[::7]
    here = integrability.study(work)
    assert len({task["group"] for task in work}) >= 8 and len({row["exponent"] for row in here}) == len(work)
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as executor:
        assert integrability.digest(list(executor.map(integrability.measured, work))) == integrability.digest(here)
