"""`stiefel linearize`."""
import numpy as np

SCENE = {"system": "rigid_body", "step": 0.05, "method": {"name": "variational"},
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.3, 1, 0.2]}}


def test_the_matrix_is_that_of_its_halves(stiefel, write):
    whole = stiefel("linearize", write(SCENE), "--to", 20, "--every", 10).json
    rest = stiefel("linearize", write(SCENE), "--from", 10, "--to", 20).json
    assert whole["outcome"] == rest["outcome"] == "REACHED"
    assert [result["step"] for result in whole["results"]] == [0, 10, 20]
    start, half, end = (np.array(result["matrix"]) for result in whole["results"])
    np.testing.assert_allclose(start, np.eye(6), rtol=0, atol=1e-15)
    np.testing.assert_allclose(np.array(rest["results"][0]["matrix"]) @ half, end, rtol=0, atol=1e-12)
    assert abs(np.linalg.det(end) - 1) < 1e-12 and np.shape(whole["results"][0]["start_basis"])[0] == 6


def test_a_column_for_every_parameter(stiefel, write):
    found = stiefel("linearize", write(SCENE), "--to", 2, "--inertia", "--by-step").json
    assert np.shape(found["results"][0]["matrix"]) == (6, 6 + 3 + 1)


def test_what_has_no_tangent_is_refused(stiefel, write):
    done = stiefel("linearize", write({**SCENE, "method": {"name": "adaptive"}}), "--to", 2)
    assert done.status == 2 and "adaptive" in done.err and "no tangent map" in done.err
