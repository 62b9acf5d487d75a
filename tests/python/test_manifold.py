"""Manifolds of frames: geodesics against exponentials of whole matrices, parallel transport against its definition."""
import re
import sys
from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

import stiefel
from stiefel.manifold import SpecialOrthogonal, Stiefel

LAMBDA = [1, 2, 3, 0.5, 4]
KINDS = {
    "euclidean": lambda client: Stiefel(3, 8),
    "canonical": lambda client: Stiefel(2, 5, "canonical"),
    "beta": lambda client: Stiefel(4, 5, 0.3),
    "whole": lambda client: Stiefel(4, 4, 0.7),
    "sphere": lambda client: Stiefel(1, 4),
    "lambda": lambda client: Stiefel(2, 5, LAMBDA, client=client),
    "rotations": lambda client: SpecialOrthogonal(4),
    "body": lambda client: SpecialOrthogonal(3, [1, 2, 0.3], client=client),
}
BETAS = ["euclidean", "canonical", "beta", "whole", "sphere"]


@pytest.fixture(scope="module", params=KINDS)
def manifold(request, client):
    return KINDS[request.param](client)


def exponential(A):
    """Returns exp(A) by a Taylor series in extended precision."""
    A = A.astype(np.longdouble) / 2**10
    term = total = np.eye(len(A), dtype=np.longdouble)
    for k in range(1, 16):
        term = term @ A / k
        total = total + term
    for _ in range(10):
        total = total @ total
    return total


@pytest.mark.parametrize("kind", BETAS)
def test_geodesics_are_those_of_the_group_that_moves_frames(kind, client):
    """U(t) = exp(t X) U exp(t (1 - 2 beta) A) with the skew N x N matrix X of the velocity (Hüper et al. 2021)."""
    manifold = KINDS[kind](client)
    beta = {"canonical": 0.5, "beta": 0.3, "whole": 0.7}.get(kind, 1.0)
    Q = manifold.random(seed=1)
    V = 2.5 * manifold.random_tangent(Q, seed=2)
    U, A = Q.T, Q @ V.T
    H = V.T - U @ A
    X = 2 * beta * U @ A @ U.T + H @ U.T - U @ H.T
    expected = exponential(X) @ U @ exponential((1 - 2 * beta) * A)
    np.testing.assert_allclose(manifold.exp(Q, V), expected.T.astype(float), atol=4e-15)


def test_the_logarithm_is_the_inverse_of_exp(manifold):
    Q = manifold.random(3, seed=1)
    lengths = np.array([0.3, 0.6, 0.9]) * (manifold.injectivity_radius or 1)
    V = lengths[:, None, None] * manifold.random_tangent(Q, seed=2)
    joined = manifold.join(Q, manifold.exp(Q, V))
    np.testing.assert_allclose(joined.velocity, V, atol=1e-13)
    np.testing.assert_allclose(joined.distance, lengths, rtol=1e-13)
    if manifold.injectivity_radius:
        assert set(joined.shortest) == {"yes"}


@pytest.mark.parametrize("metric", ["euclidean", "canonical", 0.7])
@pytest.mark.parametrize("n, N", [(1, 80), (2, 50), (5, 40)])
def test_frames_that_are_joined_in_their_span_have_the_geodesics_of_whole_frames(metric, n, N, client):
    """`normalize` sends whole frames."""
    manifold = Stiefel(n, N, metric=metric, client=client)
    Q = manifold.random(seed=1)
    V = manifold.random_tangent(Q, seed=2)
    turn = np.zeros((n, N))
    turn[0] = manifold.tangent(Q, np.eye(n)[:1].T @ V[:1])[0]  # one vector leaves the span of Q
    ends = [Q, manifold.exp(Q, 2 * V), manifold.exp(Q, 1e-9 * V), manifold.exp(Q, 1e-4 * V),
            manifold.exp(Q, manifold.tangent(Q, turn)), manifold.exp(Q, 2 * V).astype(np.float32).astype(float)]
    requests = [{"metric": metric} if isinstance(metric, str) else {"metric": "beta", "beta": metric}]
    requests += [{"inertia": [2.5] * N}] * (metric == "euclidean")
    joined = manifold.join(Q, np.array(ends))
    for request in requests:
        found = client.connect([(Q, P) for P in ends], samples=3, **request)
        whole = client.connect([(Q, P) for P in ends], samples=3, normalize=True, **request)
        for k, (one, other) in enumerate(zip(found, whole)):
            assert one.shortest == other.shortest == joined.shortest[k] and bool(one.scene) == bool(other.scene)
            np.testing.assert_allclose(manifold.exp(Q, one.velocity), ends[k], atol=1e-13 if k < 5 else 1e-7)
            np.testing.assert_allclose(one.energy, other.energy, atol=1e-13)
            for array, of_whole in ((one.velocity, other.velocity), (joined.velocity[k], other.velocity), (one.trajectory, other.trajectory)):
                np.testing.assert_allclose(array, of_whole, atol=1e-14)
            if other.scene:
                assert {**one.scene, "initial": 0} == {**other.scene, "initial": 0}
                for name, block in other.scene["initial"].items():
                    np.testing.assert_allclose(one.scene["initial"][name], block, atol=1e-13)


class Missing:
    """A client that does not join the pair 1 of each call."""

    def __init__(self, client):
        self._client = client

    def connect(self, pairs, **more):
        found = list(self._client.connect(pairs, **more))
        stalled = stiefel.RunStatus(stiefel.Outcome.SOLVER_STALLED, message="no geodesic from Q_0 to Q_T was found")
        return [replace(one, velocity=None, run_status=stalled, shortest="unspecified") if k == 1 else one for k, one in enumerate(found)]


def test_a_pair_that_is_not_joined_does_not_lose_the_others(client):
    S, T = Stiefel(2, 5, client=client), Stiefel(2, 5, client=Missing(client))
    Q, P = S.random(3, seed=1), S.random((2, 3), seed=2)
    with pytest.raises(stiefel.manifold.NotJoined, match="1 of 6 pairs of frames were not joined. Pair 1: no geodesic from Q_0 to Q_T "
                       "was found; partial=True gives NaN for it and the geodesics of the others") as caught:
        T.log(Q, P)
    assert caught.value.pairs == (1,)
    whole, part = S.join(Q, P), T.join(Q, P, partial=True)
    assert np.isnan(part.velocity[0, 1]).all() and np.isnan(part.distance[0, 1]) and np.isnan(part.residual[0, 1])
    assert part.shortest[0, 1] == "unknown" and "6 pairs, 1 not joined: distance" in repr(part)
    for name in ("velocity", "distance", "residual", "shortest"):
        one, other = (getattr(joined, name).reshape(6, -1)[[0, 2, 3, 4, 5]] for joined in (part, whole))
        assert (one == other).all(), name
    assert np.isnan(T.log(Q, P, partial=True)[0, 1]).all() and np.isnan(T.dist(Q, P, partial=True)[0, 1])
    assert "2 pairs, 1 not joined" in repr(T.join(Q[:2], P[0, :2], partial=True))


def test_a_pair_without_a_geodesic_is_told_in_the_words_of_geometry(client):
    Q, P = Stiefel(3, 4).random(2, seed=1)
    with pytest.raises(stiefel.manifold.NotJoined, match="Pair 0: no geodesic from Q_0 to Q_T was found; partial=True"):
        Stiefel(3, 4, 1e4, client=client).log(Q, P)
    missed = client.geodesic(np.geomspace(1, 1e10, 3), np.eye(2, 3), -np.eye(2, 3))
    assert missed.run_status.message == f"no geodesic from Q_0 to Q_T was found; the best one misses Q_T by {missed.residual:.2g}"


def test_dist_warns_where_a_geodesic_is_not_proved_to_be_the_shortest(client, recwarn):
    S = Stiefel(2, 4, client=client)
    Q = S.random(seed=1)
    S.dist(Q, S.exp(Q, 0.9 * np.pi * S.random_tangent(Q, seed=2)))
    assert not recwarn.list
    ends = S.exp(Q, np.multiply.outer([1.0, 4.0], S.random_tangent(Q, seed=2)))
    unproved = np.sum(S.join(Q, ends).shortest != "yes")
    with pytest.warns(UserWarning, match=f"{unproved} of 2 distances are lengths of geodesics that are not proved to be the shortest") as caught:
        S.dist(Q, ends)
    assert unproved > 0 and caught[0].filename == __file__


@pytest.mark.parametrize("layout", ["rows", "columns"])
def test_aligned_frames_are_as_far_apart_as_their_subspaces(layout):
    """The distance of subspaces is that of the angles between them, the arccosines of the singular values of QP^T."""
    S = Stiefel(3, 9, layout=layout)
    Q, P = S.random((2, 20), seed=1)
    P = S.exp(Q, 0.8 * S.random_tangent(Q, seed=3))
    R = Stiefel(3, 3).random(20, seed=2)
    turned = R @ P if layout == "rows" else P @ R
    product = (lambda A, B: A @ np.swapaxes(B, -1, -2)) if layout == "rows" else (lambda A, B: np.swapaxes(A, -1, -2) @ B)
    angles = np.arccos(np.clip(np.linalg.svd(product(Q, turned), compute_uv=False), 0, 1))
    np.testing.assert_allclose(S.dist(Q, S.align(Q, turned)), np.linalg.norm(angles, axis=-1), atol=1e-7)
    aligned = S.align(Q, turned)
    projector = (lambda A: np.swapaxes(A, -1, -2) @ A) if layout == "rows" else (lambda A: A @ np.swapaxes(A, -1, -2))
    np.testing.assert_allclose(projector(aligned), projector(P), atol=1e-14)
    signs = np.where(np.random.default_rng(4).random(3) < 0.5, -1.0, 1.0)
    flipped = signs[:, None] * Q if layout == "rows" else Q * signs
    assert (S.align(Q, flipped, signs=True) == Q).all()


def test_what_is_tangent_is_so_beside_its_own_length(client):
    """A gradient near an optimum is the small difference of large numbers."""
    for manifold in (Stiefel(5, 50), Stiefel(4, 9, "canonical"), Stiefel(2, 5, LAMBDA, client=client), SpecialOrthogonal(3, [1, 2, 0.3], client=client)):
        Q = manifold.random(seed=1)
        V, S = manifold.random_tangent(Q, seed=2), np.random.default_rng(3).normal(size=(manifold.n, manifold.n))
        normal = 1e4 * (S + S.T) @ Q * (1 if manifold.n == manifold.N else 1 / getattr(manifold._metric, "inertia", 1))
        for Z in (manifold.tangent(Q, normal + 1e-9 * V), manifold.gradient(Q, 1e4 * (S + S.T) @ Q + 1e-9 * V),
                  manifold.tangent(Q, 1e-13 * V), manifold.log(Q, manifold.exp(Q, 1e-11 * V)), 0 * V):
            product = Z @ Q.T
            assert np.max(np.abs(product + product.T)) <= 1e-9 * np.max(np.abs(Z))
            manifold.exp(Q, Z)
        with pytest.raises(ValueError, match="must be tangent"):
            manifold.exp(Q, [1e-5 * V + 1e-10 * Q, V])
        manifold.exp(Q, sum([V, 0.3 * V, -1.3 * V]))


def test_an_adapter_projects_what_an_optimiser_gives(client, monkeypatch):
    """The difference of two vectors is tangent to their rounding alone."""
    made = ModuleType("pymanopt.manifolds.manifold")
    made.Manifold = type("Manifold", (), {"__init__": lambda self, name, dimension: None})
    monkeypatch.setitem(sys.modules, made.__name__, made)
    S = Stiefel(5, 50, layout="columns", client=client)
    Q = S.random(seed=1)
    V, W = S.random_tangent(Q, seed=2), S.random_tangent(Q, seed=3)
    short = (1e6 * V + 1e-7 * W) - 1e6 * V
    with pytest.raises(ValueError, match="must be tangent"):
        S.exp(Q, short)
    space = S.to_pymanopt()
    np.testing.assert_allclose(space.retraction(Q, short), S.exp(Q, 1e-7 * W), atol=2e-9)
    np.testing.assert_allclose(space.transport(Q, space.exp(Q, W), short), S.transport(Q, W, 1e-7 * W), atol=2e-9)


def least(f, start):
    optimize = pytest.importorskip("scipy.optimize", reason="python3-scipy is not installed")
    found = optimize.minimize(f, start, method="BFGS", options={"gtol": 1e-7})
    return found.x


def test_means_are_minima_of_distances_in_closed_form():
    """On the sphere the distance is the angle; of rotations it is sqrt(2) times the angle between them."""
    rng, sphere, turns = np.random.default_rng(1), Stiefel(1, 3), SpecialOrthogonal(3)
    weights = rng.uniform(0.1, 1, 20)
    for manifold, distance in ((sphere, lambda Q, P: np.arccos(np.clip(np.sum(Q * P, axis=(-2, -1)), -1, 1))),
                               (turns, lambda Q, P: np.arccos(np.clip((np.sum(Q * P, axis=(-2, -1)) - 1) / 2, -1, 1)) * np.sqrt(2))):
        centre = manifold.random(seed=1)
        basis = manifold.tangent(centre, np.eye(centre.size).reshape(-1, *centre.shape))
        points = manifold.exp(centre, rng.uniform(0, 1.2, (20, 1, 1)) * manifold.random_tangent(np.broadcast_to(centre, (20, *centre.shape)), seed=2))
        mean = manifold.mean(points, weights=weights)
        f = lambda x, w=weights: w @ distance(manifold.exp(centre, np.tensordot(x, basis, 1)), points)**2  # noqa: E731
        minimum = manifold.exp(centre, np.tensordot(least(f, np.zeros(len(basis))), basis, 1))
        np.testing.assert_allclose(mean.frame, minimum, atol=1e-6)
        assert mean.residual < 1e-12 and mean.converged and mean.proved and mean.iterations < 10
        np.testing.assert_allclose(mean.variance, weights @ distance(mean.frame, points)**2 / weights.sum(), rtol=1e-12)


def test_a_mean_has_the_least_sum_of_squared_distances(manifold):
    """Against BFGS over the tangent space at a point nearby; the mean of two points divides their geodesic."""
    Q = manifold.random(seed=1)
    V = 0.6 * manifold.random_tangent(np.broadcast_to(Q, (2, 5, *Q.shape)), seed=2)
    points = manifold.exp(Q, V)
    means = manifold.mean(points)
    assert means.frame.shape == (2, *Q.shape) and means.residual.max() < 1e-12 and means.converged.all()
    alone = manifold.mean(points[1], weights=[2, 2, 2, 2, 2])
    np.testing.assert_allclose(alone.frame, means.frame[1], atol=1e-12)
    two = manifold.mean(points[0, :2], weights=[3, 1])
    np.testing.assert_allclose(two.frame, manifold.exp(points[0, 0], manifold.log(points[0, 0], points[0, 1]) / 4), atol=1e-11)
    W = manifold.random_tangent(np.broadcast_to(means.frame[0], (2, *Q.shape)), seed=3)
    f = lambda x: np.sum(manifold.join(manifold.exp(means.frame[0], np.tensordot(x, W, 1)), points[0]).distance**2)  # noqa: E731
    assert np.abs(least(f, np.full(2, 0.05))).max() < 1e-5


def test_a_mean_says_where_there_is_none(client):
    S = Stiefel(2, 5, layout="columns", client=client)
    Q = S.random(3, seed=1)
    with pytest.warns(UserWarning, match=r"1 of 1 means did not converge in 1 iterations: the residual is \S+e-0") as caught:
        mean = S.mean(Q, most=1)
    assert caught[0].filename == __file__ and not mean.converged and "1 not converged" in repr(mean) and mean.frame.shape == (5, 2)
    assert repr(S.mean(Q[:1])) == "<stiefel.manifold.Mean (5, 2): residual at most 0.0e+00 after 0 iterations>"
    for points, weights, said in ((Q[0], None, r"points: the shape \(5, 2\): must be \(..., points, 5, 2\)"), (Q, [1, 1], "weights: must be 3 numbers"),
                                  (Q, [1, -1, 1], "of at least 0"), (Q, [0, 0, 0], "with a positive sum"), (Q[:0], None, "points: the shape")):
        with pytest.raises(ValueError, match=said):
            S.mean(points, weights=weights)


def test_frames_without_a_path_are_refused_by_their_index():
    with pytest.raises(stiefel.InvalidArgument, match=r"pairs\[1\].Q_T: det Q_0 = 1 and det Q_T = -1"):
        SpecialOrthogonal(3).log([np.eye(3), np.eye(3)], [np.eye(3), np.diag([1, 1, -1])])


def test_a_transported_vector_stays_parallel(manifold):
    """The covariant derivative of W(t) is its ordinary one less (acceleration(V + W) - acceleration(V - W)) / 4."""
    Q = manifold.random(seed=1)
    V, W = 0.8 * manifold.random_tangent(Q, seed=2), manifold.random_tangent(Q, seed=3)
    h = 2e-3

    def derivative(values):
        return (8 * (values[2] - values[1]) - (values[3] - values[0])) / (12 * h)

    def acceleration(Q, V):
        frames = manifold.geodesic(Q, V, [-2 * h, -h, 0, h, 2 * h])
        return (-frames[0] + 16 * frames[1] - 30 * frames[2] + 16 * frames[3] - frames[4]) / (12 * h * h)

    times = [0.5 - 2 * h, 0.5 - h, 0.5 + h, 0.5 + 2 * h]
    change = derivative([manifold.transport(Q, t * V, W) for t in times])
    there, along, across = manifold.exp(Q, 0.5 * V), manifold.transport(Q, 0.5 * V, V), manifold.transport(Q, 0.5 * V, W)
    np.testing.assert_allclose(along, derivative(manifold.geodesic(Q, V, times)), atol=1e-9)
    turned = (acceleration(there, along + across) - acceleration(there, along - across)) / 4
    np.testing.assert_allclose(change, turned, atol=2e-7)
    np.testing.assert_allclose(manifold.norm(there, across), 1, atol=1e-13)
    np.testing.assert_allclose(manifold.inner(there, along, across), manifold.inner(Q, V, W), atol=1e-13)


def test_gradient_and_hessian_are_the_derivatives_along_geodesics(manifold):
    n, N = manifold.shape
    X = np.random.default_rng(4).normal(size=(n * N, n * N))
    X = X + X.T
    Q = manifold.random(seed=1)
    V, W = manifold.random_tangent(Q, seed=2), manifold.random_tangent(Q, seed=3)
    slope = (X @ Q.ravel()).reshape(n, N)
    h = 4e-3
    f = [frame.ravel() @ X @ frame.ravel() / 2 for frame in manifold.geodesic(Q, V, [-2 * h, -h, 0, h, 2 * h])]
    first = (8 * (f[3] - f[1]) - (f[4] - f[0])) / (12 * h)
    second = (-f[0] + 16 * f[1] - 30 * f[2] + 16 * f[3] - f[4]) / (12 * h * h)
    hessian = [manifold.hessian(Q, slope, (X @ vector.ravel()).reshape(n, N), vector) for vector in (V, W)]
    np.testing.assert_allclose(manifold.inner(Q, manifold.gradient(Q, slope), V), first, atol=1e-8 * np.abs(X).sum())
    np.testing.assert_allclose(manifold.inner(Q, hessian[0], V), second, atol=1e-7 * np.abs(X).sum())
    np.testing.assert_allclose(manifold.inner(Q, hessian[0], W), manifold.inner(Q, hessian[1], V), atol=1e-12)


def test_leading_axes_and_columns_give_the_same_numbers():
    rows, columns = Stiefel(2, 5), Stiefel(2, 5, layout="columns")
    Q = rows.random((3, 2), seed=1)
    V = rows.random_tangent(Q, seed=2)
    turned = np.swapaxes(Q, -1, -2), np.swapaxes(V, -1, -2)
    many = rows.exp(Q, V)
    np.testing.assert_array_equal(columns.exp(*turned), np.swapaxes(many, -1, -2))
    np.testing.assert_array_equal(many[1, 1], rows.exp(Q[1, 1], V[1, 1]))
    np.testing.assert_array_equal(rows.join(Q, many).velocity[2, 1], rows.log(Q[2, 1], many[2, 1]))
    assert rows.dist(Q, many).shape == (3, 2) and rows.random().shape == (2, 5) and columns.random(4).shape == (4, 5, 2)


def test_frames_and_tangents_are_what_they_are_called(manifold):
    Q = manifold.random(4, seed=1)
    V = manifold.random_tangent(Q, seed=1)  # the seed of its frame
    np.testing.assert_allclose(Q @ np.swapaxes(Q, -1, -2), np.broadcast_to(np.eye(manifold.n), (4, manifold.n, manifold.n)), atol=1e-14)
    np.testing.assert_allclose(V @ np.swapaxes(Q, -1, -2) + Q @ np.swapaxes(V, -1, -2), 0, atol=1e-14)
    np.testing.assert_allclose(manifold.norm(Q, V), 1, atol=1e-14)
    np.testing.assert_allclose(manifold.project(1.5 * Q), Q, atol=1e-14)
    Z = np.random.default_rng(5).normal(size=Q.shape)
    np.testing.assert_allclose(manifold.inner(Q, Z - manifold.tangent(Q, Z), V), 0, atol=1e-12)
    if isinstance(manifold, SpecialOrthogonal):
        np.testing.assert_allclose(np.linalg.det(Q), 1, atol=1e-14)


@pytest.mark.parametrize("make, said", [
    (lambda: Stiefel(4, 3), "n = 4, N = 3: must be 1 <= n <= N"),
    (lambda: Stiefel(8, 3), "N = 3: .*; Stiefel\\(n, N\\) has n vectors of N numbers"),
    (lambda: Stiefel(2, 3, "round"), "metric: 'round': must be"),
    (lambda: Stiefel(2, 3, [1, 2]), "3 positive numbers"),
    (lambda: SpecialOrthogonal(3, [1, -2, 3]), "sum of any two"),
    (lambda: Stiefel(2, 3, layout="C"), "layout: 'C'"),
    (lambda: Stiefel(2, 3).exp(np.eye(3), np.eye(3)), r"the shape \(3, 3\): must end with \(2, 3\)"),
    (lambda: Stiefel(2, 3).log(np.eye(3, 2), np.eye(3, 2)), "layout 'rows'; layout='columns' takes this one$"),
    (lambda: Stiefel(2, 3, layout="columns").project(np.eye(2, 3)), "layout 'columns'; layout='rows' takes this one$"),
    (lambda: Stiefel(2, 3).log(np.ones((4, 1, 1)) * np.eye(2, 3), np.ones((3, 1, 1)) * np.eye(2, 3)), r"axes \(4,\) and \(3,\) do not broad"),
    (lambda: Stiefel(2, 3).exp(np.ones((4, 1, 1)) * np.eye(2, 3), np.zeros((3, 2, 3))), r"axes \(4,\) and \(3,\) do not broadcast"),
    (lambda: Stiefel(2, 3).exp(2 * np.eye(2, 3), np.zeros((2, 3))), r"max \|QQ\^T - I\| = 3.0e\+00: frames must .*; project"),
    (lambda: Stiefel(2, 3).log(np.eye(2, 3), np.full((2, 3), np.nan)), r"= nan: frames must"),
    (lambda: Stiefel(2, 3).exp(np.eye(2, 3), np.eye(2, 3)), r"max \|VQ\^T \+ QV\^T\| = 2.0e\+00: must be tangent at Q"),
    (lambda: Stiefel(2, 3).transport(np.eye(2, 3), np.zeros((2, 3)), np.ones((2, 3))), "must be tangent at Q"),
])
def test_what_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()


def test_velocities_of_an_energy_and_a_momentum(manifold):
    Q = manifold.random(4, seed=1)
    W = manifold.random_tangent(Q, seed=2)
    B = np.random.default_rng(3).normal(size=(manifold.n, manifold.n))
    m = manifold.momentum(Q, W)
    paired = manifold.inner(Q, W, (B - B.T) @ Q)
    np.testing.assert_allclose(paired, np.sum(m * (B - B.T), axis=(-2, -1)) / 2, atol=1e-14)
    if manifold.n == manifold.N:
        with pytest.raises(ValueError, match="direction"):
            manifold.velocity(Q, W, 0.5)
        return
    asked = 0.1 * (B - B.T)
    V = manifold.velocity(Q, W, 0.7, asked)
    np.testing.assert_allclose(manifold.inner(Q, V, V), 1.4, rtol=1e-14)
    np.testing.assert_allclose(manifold.momentum(Q, V), np.broadcast_to(asked, (4, *asked.shape)), atol=1e-14)
    np.testing.assert_allclose(manifold.tangent(Q, V), V, atol=1e-14)
    assert (manifold.inner(Q, V, W) > 0).all()
    if manifold.n > 1:
        with pytest.raises(ValueError, match="energy: 0.001: must be at least"):
            manifold.velocity(Q, W, 0.001, asked)


def test_a_geodesic_keeps_its_momentum(client):
    manifold = Stiefel(3, 5, LAMBDA, client=client)
    Q = manifold.random(seed=1)
    m = np.array([[0, 0.1, -0.2], [-0.1, 0, 0.3], [0.2, -0.3, 0]])
    V = manifold.velocity(Q, manifold.random_tangent(Q, seed=2), 0.5, m)
    scene = {"system": "stiefel", "inertia": LAMBDA, "step": 0.1, "initial": {"Q": Q, "Qdot": V}}
    with client.create(scene) as session:
        last = session.step(to=100)
    np.testing.assert_allclose(manifold.momentum(last["Q"], last["S"] / LAMBDA), m, atol=1e-12)
