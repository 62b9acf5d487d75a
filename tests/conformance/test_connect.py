"""Connect: the geodesic that joins two frames."""
import numpy as np
import pytest

import stiefel


def ends(n, N, seed):
    random = np.random.default_rng(seed)
    frames = [np.linalg.qr(random.standard_normal((N, n)))[0].T for _ in range(2)]
    if n == N:
        frames = [Q * np.sign(np.linalg.det(Q)) if N % 2 else Q[:, [1, 0, *range(2, N)]] if np.linalg.det(Q) < 0 else Q
                  for Q in frames]
    return frames


@pytest.mark.parametrize("n, N", [(1, 3), (2, 5), (3, 3), (4, 4)])
def test_its_scene_arrives(client, n, N):
    Q_0, Q_T = ends(n, N, 7)
    found = client.geodesics([(Q_0, Q_T)], inertia=np.linspace(1, 3, N), time=2.0, samples=8)[0]
    assert found.outcome == stiefel.Outcome.REACHED and found.residual <= 1e-11
    assert found.scene["system"] == ("rigid_body" if n == N else "stiefel")
    assert found.trajectory.shape == (9, n, N)
    np.testing.assert_allclose(found.trajectory[0], Q_0, atol=2e-15)
    np.testing.assert_allclose(found.trajectory[-1], Q_T, atol=1e-10)
    with client.create(found.scene) as session:
        np.testing.assert_array_equal(session.step(8)["Q"], found.trajectory[-1])
        energy, = session.diagnose(8, invariants=["energy"]).invariants
        assert energy.initial == pytest.approx(found.energy, rel=1e-13)


def test_unequal_determinants_have_a_reason_of_their_own(client):
    with pytest.raises(stiefel.InvalidArgument) as refused:
        client.geodesics([(np.eye(3), np.diag([1, 1, -1]))], inertia=[1, 2, 3])[0]
    assert refused.value.reason == "UNEQUAL_DETERMINANTS"
    assert refused.value.metadata == {"Q_0": "1", "Q_T": "-1"}


def test_the_euclidean_metric_is_that_of_the_identity(client):
    pair = ends(2, 4, 1)
    euclidean, = client.geodesics([pair], metric="euclidean")
    assert euclidean.energy == client.geodesics([pair], inertia=np.ones(4))[0].energy


def moved(Q, V, beta, t=1.0):
    """The frame at t of the geodesic of beta, from the group that acts on frames (Hüper, Markina and Silva Leite 2021)."""
    U, A = Q.T, Q @ V.T
    H = V.T - U @ A
    X = 2 * beta * U @ A @ U.T + H @ U.T - U @ H.T
    turned = [np.linalg.eig(t * skew) for skew in (X, (1 - 2 * beta) * A)]
    left, right = ((vectors * np.exp(values)) @ np.linalg.inv(vectors) for values, vectors in turned)
    return (left @ U @ right).real.T


@pytest.mark.parametrize("metric, beta", [("canonical", 0.5), ("beta", 0.3)])
def test_metrics_without_a_scene_have_a_velocity(client, metric, beta):
    Q_0, Q_T = ends(3, 8, 1)
    found, = client.geodesics([(Q_0, Q_T)], metric=metric, beta=beta if metric == "beta" else None, time=2.0, samples=4)
    assert found.outcome == stiefel.Outcome.REACHED and found.scene is None and found.residual <= 1e-11
    for k, frame in enumerate(found.trajectory):
        np.testing.assert_allclose(frame, moved(Q_0, 2 * found.velocity, beta, k / 4), atol=1e-12)
    np.testing.assert_allclose(found.trajectory[-1], Q_T, atol=1e-12)
    A = found.velocity @ Q_0.T
    assert found.energy == pytest.approx((np.sum(found.velocity**2) - (1 - beta) * np.sum(A**2)) / 2, rel=1e-12)


def test_the_view_decides_whether_there_is_a_scene(client):
    pair = ends(2, 4, 1)
    whole, = client.geodesics([pair], metric="euclidean")
    bare, = client.geodesics([pair], metric="euclidean", scenes=False)
    assert bare.scene is None and whole.scene is not None
    np.testing.assert_array_equal(bare.velocity, whole.velocity)
    start = {name: np.array(block) for name, block in whole.scene["initial"].items()}
    np.testing.assert_array_equal(start["S"], whole.velocity)


def test_large_frames_arrive(client):
    """The arrays of 2 x 200000 frames take 3.2 MB each, more than gRPC's default of 4 MiB together."""
    random = np.random.default_rng(5)
    Q_0, Q_T = (np.linalg.qr(random.standard_normal((200_000, 2)))[0].T for _ in range(2))
    found, = client.geodesics([(Q_0, Q_T)], metric="euclidean")
    np.testing.assert_allclose(found.velocity @ Q_0.T, -(found.velocity @ Q_0.T).T, atol=1e-14)
    assert len(found.scene["inertia"]) == 200_000
    np.testing.assert_array_equal(np.array(found.scene["initial"]["S"]), found.velocity)


def test_a_batch_has_the_bits_of_each_pair_alone(client):
    pairs = [ends(2, 5, seed) for seed in range(60)]
    inertia = np.geomspace(1, 100, 5)
    for some, alone in zip(client.geodesics(pairs, inertia=inertia, scenes=False), pairs):
        one, = client.geodesics([alone], inertia=inertia, scenes=False)
        np.testing.assert_array_equal(some.velocity, one.velocity)
        assert (some.energy, some.residual, some.shortest) == (one.energy, one.residual, one.shortest)


def test_one_bad_pair_of_many_is_named_before_anything_moves(client):
    pairs = [ends(2, 4, seed) for seed in range(200)]
    for poison, said in ((np.nan, "finite"), (2.0, "orthonormal")):
        bad = pairs[137][1].copy()
        bad[0, 0] = poison
        with pytest.raises(stiefel.InvalidArgument, match=rf"pairs\[137\].Q_T.*{said}"):
            client.geodesics([*pairs[:137], (pairs[137][0], bad), *pairs[138:]], metric="canonical")


def test_a_budget_ends_a_search_with_the_shortest_geodesic_so_far(client):
    pair, problem = ends(2, 5, 7), {"inertia": np.geomspace(1, 100, 5), "restarts": 1000}
    found, again = client.geodesics([pair, pair], budget=0.5, **problem)
    assert found.outcome == stiefel.Outcome.REACHED and found.shortest == again.shortest == "ended" and found.residual <= 1e-11
    np.testing.assert_array_equal(found.velocity, again.velocity)
    none, = client.geodesics([pair], budget=1e-6, **problem)
    assert none.outcome == stiefel.Outcome.SOLVER_STALLED and "the budget ended the search" in none.run_status.message


@pytest.mark.parametrize("change, fault", [
    ({"time": 0.0}, "time"), ({"time": float("nan")}, "time"), ({"inertia": [1, 2]}, "inertia"),
    ({"inertia": [1, 2, -3]}, "inertia"), ({"Q_T": [[1, 1, 0]]}, "Q_T.*orthonormal"), ({"Q_T": np.eye(3)}, "Q_T"),
    ({"metric": "canonical"}, "inertia"), ({"metric": "beta"}, "beta"), ({"beta": 0.5}, "beta"),
    *(({"inertia": [], "metric": "beta", "beta": beta}, "beta") for beta in (-1.0, 0.0, np.nan, np.inf)),
    ({"time": 1e-300}, "time"), ({"steps": 10**6}, "steps"), ({"samples": 10**6}, "samples"), ({"restarts": 10**6}, "restarts"),
    ({"budget": -1.0}, "budget"), ({"budget": 1.0, "steps": 4}, "budget"),
], ids=lambda value: None if isinstance(value, str) else "".join(value))
def test_what_has_no_meaning_names_the_field(client, change, fault):
    problem = {"inertia": [1, 2, 3], "Q_0": [[1, 0, 0]], "Q_T": [[0, 1, 0]], **change}
    with pytest.raises(stiefel.InvalidArgument, match=fault):
        client.geodesics([(problem.pop("Q_0"), problem.pop("Q_T"))], **problem)
