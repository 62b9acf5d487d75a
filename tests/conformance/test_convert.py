"""Convert: the same motion in other variables, and back."""
import numpy as np
import pytest

import scenes
import stiefel


def test_velocity_and_generator(client):
    scene = scenes.frame(2, 5)
    velocity, generator = (client.convert(scene, system=to).blocks for to in ("velocity", "angular_velocity"))
    np.testing.assert_allclose(velocity["Qdot"] * scene["inertia"], scene["initial"]["S"], atol=1e-14)
    np.testing.assert_allclose(velocity["Q"] @ generator["U"], velocity["Qdot"], atol=1e-13)
    np.testing.assert_array_equal(generator["U"], -generator["U"].T)


def test_interpolation_weights_are_symmetric(client):
    """Checks [RB] (7.15) and (7.20), and with (7.16) and (7.21) the way back to P."""
    scene = scenes.free(4)
    b = client.convert(scene, system="interpolation").blocks
    inertia = np.diag(scene["inertia"])
    for weight in ("Sigma", "Lambda_k"):
        np.testing.assert_allclose(b[weight], b[weight].T, atol=1e-13)
    np.testing.assert_allclose(b["Q"] @ b["Sigma"] - b["Q_prev"] @ inertia, b["P"], atol=1e-13)
    np.testing.assert_allclose(b["Q"] @ b["Lambda_k"] + b["Q_next"] @ inertia, b["P"], atol=1e-13)


def test_epsilon_makes_room_for_any_momentum(client):
    scene = scenes.free(4)
    big = {**scene, "initial": {"Q": scene["initial"]["Q"], "M": 1e6 * scene["initial"]["M"]}}
    converted = client.convert(big, system="symmetric_rigid_body")
    assert converted.scene["epsilon"] < 1e-5 and converted.margins["S_M"] >= 1
    with pytest.raises(stiefel.InvalidArgument, match="S_M") as refused:
        client.convert(big, system="symmetric_rigid_body", epsilon=1)
    assert refused.value.reason == "OUTSIDE_DOMAIN"
    norm = np.linalg.norm(big["initial"]["M"], 2)
    assert float(refused.value.metadata["value"]) == pytest.approx(norm, rel=1e-12)
    assert refused.value.metadata["bound"] == "2"


@pytest.mark.parametrize("scene, to, fault", [
    (scenes.free(4), "no_system", "to: no_system: must be a system or one of velocity"),
    (scenes.free(4), "double_bracket", "to: double_bracket: cannot be reached"),
    (scenes.frame(2, 5), "rigid_body", "to: rigid_body: needs n = N: Q is 2 x 5"),
    (scenes.frame(2, 5), "ellipsoid", "V.1, N."),
    (scenes.frame(2, 5), "discrete_stiefel", "n = N: the value is 2, the bound 5"),
    (scenes.rigid_body(initial={"M": scenes.M3}), "velocity", "scene.initial.Q: absent"),
    (scenes.rigid_body(step=0), "velocity", "step"),
], ids=["unknown", "unreachable", "not square", "not a vector", "not the flow", "no frame", "no scene"])
def test_what_has_no_other_form_is_refused(client, scene, to, fault):
    with pytest.raises(stiefel.InvalidArgument, match=fault):
        client.convert(scene, system=to)
