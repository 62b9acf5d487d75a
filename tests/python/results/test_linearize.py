"""The derivative of the computed steps, against differences of sessions."""
import datetime

import numpy as np
import pytest

import stiefel

BODY = {"system": "rigid_body", "method": {"name": "variational", "order": 4}, "step": 0.05, "inertia": [2.5, 1.5, 0.5],
        "initial": {"Q": np.eye(3), "M": [[0, -0.3, 2], [0.3, 0, -1], [-2, 1, 0]]}}


def vee(A):
    return np.array([A[2, 1], A[0, 2], A[1, 0]])


def hat(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def exp(v):
    angle = np.linalg.norm(v)
    return np.eye(3) + np.sin(angle) / angle * hat(v) + (1 - np.cos(angle)) / angle**2 * hat(v) @ hat(v)


@pytest.fixture
def session(client):
    with client.create(BODY) as session:
        yield session


def test_vectors_as_blocks_and_by_coordinates_agree(session):
    whole = session.linearize(to=30)
    by_coordinates = session.linearize(to=30, vectors=np.eye(6)[[1, 4]])
    blocks = session.linearize(to=30, vectors=whole.start_basis[[1, 4]])
    assert (by_coordinates.matrix == whole.matrix[:, [1, 4]]).all() and blocks.matrix is None
    np.testing.assert_allclose(np.einsum("dk,drc->krc", by_coordinates.matrix, whole.basis), blocks.vectors, atol=1e-13)


def test_results_on_the_way_are_those_of_calls_of_their_own(session):
    run = session.linearize(to=25, start=5, every=10)
    assert run.step.tolist() == [5, 15, 25] and np.allclose(run.matrix[0], np.eye(6), rtol=0, atol=1e-15)
    assert (run.matrix[1] == session.linearize(to=15, start=5).matrix).all()


def test_a_covariance_is_moved(session):
    P0 = np.diag([1e-6, 2e-6, 3e-6, 1e-4, 2e-4, 3e-4])
    Phi = session.linearize(to=20).matrix
    np.testing.assert_allclose(session.covariance(P0, to=20), Phi @ P0 @ Phi.T, rtol=1e-15)
    with pytest.raises(stiefel.InvalidArgument, match="P0"):
        session.covariance(np.eye(5), to=20)


@pytest.mark.parametrize("method", [{"name": "exact"}, {"name": "variational", "order": 4}], ids=lambda method: method["name"])
def test_a_covariance_of_angle_and_rate(client, method):
    """Against differences of bodies that are turned and spun otherwise at the start."""
    tensor, attitude, spin = [[3, 0.2, -0.1], [0.2, 2, 0.3], [-0.1, 0.3, 4]], exp(np.array([0.3, -0.2, 0.5])), np.array([0.1, 1, 0.2])
    scene = {"system": "rigid_body", "method": method, "step": 0.1, "epoch": "2016-12-31T23:59:59 UTC"}

    def ends(d):
        body = {"inertia_tensor": tensor, "attitude": attitude @ exp(d[:3] + 1e-30), "angular_velocity": spin + d[3:]}
        with client.create({**scene, "body": body}) as other:
            state = other.step(to=40, fields=["Q", "angular_velocity"])
        return state["Q"], state["angular_velocity"]

    h, columns = 1e-4, []
    Q = ends(np.zeros(6))[0]
    for d in h * np.eye(6):
        (plus, faster), (minus, slower) = ends(d), ends(-d)
        eta = Q.T @ (plus - minus) / (2 * h)
        columns.append(np.hstack([vee((eta - eta.T) / 2), (faster - slower) / (2 * h)]))
    Phi, P0 = np.transpose(columns), np.diag([1e-6, 2e-6, 3e-6, 1e-4, 2e-4, 3e-4])
    with client.create({**scene, "body": {"inertia_tensor": tensor, "attitude": attitude, "angular_velocity": spin}}) as session:
        P = session.covariance(P0, to=40, rates=True)
        np.testing.assert_allclose(P, Phi @ P0 @ Phi.T, atol=1e-6 * np.max(P))
        several = session.covariance(P0, times=[4.0, 0, 1.5], rates=True)
        assert several.shape == (3, 6, 6) and np.allclose(several[1], P0, rtol=1e-12, atol=1e-18)
        np.testing.assert_allclose(several[0], P, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(several[2], session.covariance(P0, to=15, rates=True), rtol=1e-12, atol=1e-15)
        instants = ["2017-01-01T00:00:02 UTC", datetime.datetime(2016, 12, 31, 23, 59, 59)]  # the last minute has 61 seconds
        np.testing.assert_array_equal(session.covariance(P0, times=instants, rates=True), several[:2])
        np.testing.assert_array_equal(session.covariance(P0, time=instants[0]), session.covariance(P0, to=40))
        for more, field in (({"times": [0.1, 0.25]}, r"times\[1\]: 0.25: must be a whole number of steps"), ({"times": [1.0], "to": 3}, "to: 3: must be absent"),
                            ({"times": [1.0], "start": 11}, "times: 1.0: is before step 11"), ({"times": []}, "times: the shape")):
            with pytest.raises(stiefel.InvalidArgument, match=field):
                session.covariance(P0, **more)


def test_rates_are_of_a_body_in_three_dimensions(client):
    scene = {"system": "stiefel", "method": {"name": "variational"}, "step": 0.1, "inertia": [1, 2, 3],
             "initial": {"Q": np.eye(2, 3), "Qdot": [[0, 0, 1], [0, 0, 0.5]]}}
    with client.create(scene) as session, pytest.raises(stiefel.InvalidArgument, match="rates: True: must be False, because stiefel"):
        session.covariance(np.eye(6), to=3, rates=True)


def test_a_gradient_by_state_inertia_and_step(client, session):
    """Of m_1 at the last state."""
    slope = np.eye(6)[3]
    gradient = session.linearize(to=20, inertia=True, step=True).gradient(slope)
    assert gradient.shape == (10,)
    for k in range(4):
        ends = []
        for change in (1e-5, -1e-5):
            inertia, step = list(BODY["inertia"]), BODY["step"]
            if k < 3:
                inertia[k] += change
            else:
                step += change
            with client.create({**BODY, "inertia": inertia, "step": step}) as other:
                ends.append(vee(other.step(to=20, fields="M")["M"])[0])
        assert gradient[6 + k] == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-5, abs=1e-7)


def test_a_large_state_has_no_coordinates(client):
    """It is refused by the rule, not for the memory that its matrix would take; vectors as blocks are moved."""
    N = 40
    M = np.tri(N) - np.tri(N).T
    scene = {"system": "rigid_body", "step": 1e-3, "inertia": np.linspace(1, 2, N), "method": {"name": "rk4"},
             "initial": {"Q": np.eye(N), "M": M}}
    with client.create(scene) as session:
        with pytest.raises(stiefel.InvalidArgument, match="vectors: absent: must be given as blocks: .* up to 1024 numbers"):
            session.linearize(to=10**6)
        moved = session.linearize(to=2, vectors=np.concatenate([np.zeros((N, N)), M])[np.newaxis])
    assert moved.vectors.shape == (1, 2 * N, N) and np.isfinite(moved.vectors).all()
