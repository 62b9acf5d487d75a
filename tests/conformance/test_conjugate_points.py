"""ConjugatePoints: the conjugate points along a geodesic."""
import numpy as np
import pytest

import stiefel
from stiefel import v1 as pb


def test_those_of_a_sphere(client):
    points = client.conjugate_points(inertia=np.ones(5), Q=np.eye(1, 5), Qdot=np.eye(1, 5, k=1), time=7)
    assert points.outcome == stiefel.Outcome.REACHED and points.until == 7 and points.work > 0
    np.testing.assert_allclose([point.time for point in points], [np.pi, 2 * np.pi], rtol=1e-12)
    for point in points:
        assert point.multiplicity == 3 and point.kernel.shape == (3, 1, 5)
        kernel = point.kernel[:, 0]
        np.testing.assert_allclose(kernel @ kernel.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(kernel[:, :2], 0, atol=1e-9)


def test_a_kernel_does_not_move_the_end(client):
    inertia, Q, V = np.linspace(1, 2, 4), np.eye(2, 4), np.array([[0, 1, 0.5, 0], [-1, 0, 0, 0.7]])
    first = client.conjugate_points(inertia=inertia, Q=Q, Qdot=V, time=6)[0]
    manifold = stiefel.manifold.Stiefel(2, 4, inertia, client=client)
    change = 1e-4 * first.kernel[0]
    ends = manifold.exp(Q, first.time * np.stack([V + change, V - change]))
    assert np.abs(ends[0] - ends[1]).max() < 1e-8


def test_many_points_are_one_reply(client):
    points = client.conjugate_points(inertia=np.ones(4), Q=np.eye(1, 4), Qdot=np.eye(1, 4, k=1), time=5000.5 * np.pi)
    assert len(points) == 5000 and points.outcome == stiefel.Outcome.REACHED
    np.testing.assert_allclose(points[4999].time, 5000 * np.pi, rtol=1e-10)
    assert all(point.multiplicity == 2 for point in points)


def test_beyond_the_first_conjugate_point_another_geodesic_is_shorter(client):
    """On an ellipsoid the first conjugate point ends the shortest ways, and just before it they are still minima."""
    inertia, Q, V = [1, 1.3, 2], np.array([[0.6, 0.64, 0.48]]), np.array([[0.8, -0.48, -0.36]])
    first = client.conjugate_points(inertia=inertia, Q=Q, Qdot=V, time=9)[0].time
    length = first * np.sqrt((V**2 @ inertia)[0])
    manifold = stiefel.manifold.Stiefel(1, 3, inertia, client=client)
    far = manifold.exp(Q, 1.05 * first * V)
    assert np.sqrt(2 * client.geodesics([(Q, far)], inertia=inertia, restarts=8)[0].energy) < 1.05 * length * (1 - 1e-6)


@pytest.mark.parametrize("change, field", [
    ({"inertia": [1, 2]}, "inertia"), ({"inertia": [1, 2, -1]}, "inertia"), ({"time": -1.0}, "time"), ({"time": np.inf}, "time"), ({"inertia": [1, np.nan, 3]}, "inertia"), ({"Qdot": [[0, np.nan, 0]]}, "Qdot"),
   
    ({"Q": [[2, 0, 0]]}, "Q"), ({"Qdot": [[1, 0, 0]]}, "Qdot"), ({"Qdot": [[0, 1]]}, "Qdot"), ({"Q": [[np.nan, 0, 0]]}, "Q")])
def test_a_fault_names_its_field(client, change, field):
    with pytest.raises(stiefel.InvalidArgument) as refused:
        client.conjugate_points(**{"inertia": [1, 2, 3], "Q": [[1, 0, 0]], "Qdot": [[0, 1, 0]], "time": 1.0, **change})
    assert refused.value.violations[0].field.startswith(field)


def test_absent_frames_are_faults(client):
    with pytest.raises(stiefel.InvalidArgument) as refused:
        client._connection.call("ConjugatePoints", pb.ConjugatePointsRequest(inertia=[1, 2, 3], time=1))
    assert [violation.field for violation in refused.value.violations] == ["Q", "Qdot"]
