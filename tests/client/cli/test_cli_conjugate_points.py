"""`stiefel conjugate-points`."""
import numpy as np

RAY = {"inertia": [1, 1, 4], "Q": [[1, 0, 0]], "Qdot": [[0, 1, 0]], "time": 13}


def test_the_equator_of_an_ellipsoid_of_revolution(stiefel, write):
    done = stiefel("conjugate-points", write(RAY))
    assert done.status == 0 and done.json["outcome"] == "REACHED" and done.json["until"] == 13
    np.testing.assert_allclose([point["time"] for point in done.json["points"]], [2 * np.pi, 4 * np.pi], rtol=1e-12)
    assert [point["multiplicity"] for point in done.json["points"]] == [1, 1]
    kernel = done.json["points"][0]["kernel"][0]
    np.testing.assert_allclose(np.abs(kernel), [[0, 0, 0.5]], atol=1e-9)


def test_the_injectivity_radius(stiefel, write):
    done = stiefel("conjugate-points", write({"inertia": [1, 1, 1], "radius": {"n": 1, "starts": 1}}))
    assert done.status == 0 and abs(done.json["radius"]["upper"] - np.pi) < 1e-9
    assert abs(done.json["radius"]["lower"] - np.pi) < 1e-13


def test_a_fault_is_where_the_file_has_it(stiefel, write):
    done = stiefel("conjugate-points", write({**RAY, "Qdot": [[1, 0, 0]]}))
    assert done.status == 2 and "scene.json: Qdot" in done.err and "tangent" in done.err
    done = stiefel("conjugate-points", write({**RAY, "speed": 1}))
    assert done.status == 2 and "speed" in done.err
