"""Convert: the same motion in other variables, and back."""
import numpy as np
import pytest

import scenes
import stiefel

RIGID = ["right_rigid_body", "symmetric_rigid_body", "right_symmetric_rigid_body", "reduced_rigid_body",
         "mclachlan_scovel", "moser_veselov", "moser_veselov_pair", "symmetric_moser_veselov",
         "parametric_moser_veselov", "stiefel", "stiefel_costate", "stiefel_momentum", "discrete_stiefel"]


def array(scene, name):
    return np.array(scene["initial"][name])


@pytest.mark.parametrize("n", [3, 5])
@pytest.mark.parametrize("system", RIGID)
def test_there_and_back(client, system, n):
    scene = scenes.free(n)
    there = client.convert(scene, system)
    assert there.scene["system"] == system
    home = client.convert(there.scene, "rigid_body").scene
    np.testing.assert_allclose(array(home, "Q"), scene["initial"]["Q"], atol=1e-13)
    np.testing.assert_allclose(array(home, "M"), scene["initial"]["M"], atol=2e-12)


@pytest.mark.parametrize("system", ["stiefel_costate", "stiefel_momentum"])
def test_frames_there_and_back(client, system):
    scene = scenes.frame(2, 5)
    home = client.convert(client.convert(scene, system).scene, "stiefel").scene
    np.testing.assert_allclose(array(home, "Q"), scene["initial"]["Q"], atol=1e-13)
    np.testing.assert_allclose(array(home, "S"), scene["initial"]["S"], atol=1e-13)


def test_a_vector_is_a_point_on_the_ellipsoid(client):
    scene = scenes.frame(1, 4)
    home = client.convert(client.convert(scene, "ellipsoid").scene, "stiefel").scene
    np.testing.assert_allclose(array(home, "S"), scene["initial"]["S"], atol=1e-13)


@pytest.mark.parametrize("system", ["right_rigid_body", "symmetric_rigid_body", "mclachlan_scovel", "stiefel",
                                    "stiefel_costate", "reduced_rigid_body"])
def test_it_is_the_same_motion(client, system):
    """After a unit of time both scenes are in the same state, computed by a method whose error does not matter."""
    scene = scenes.free(4, method="adaptive", step=1.0)
    scene["method"]["tolerance"] = 1e-13
    other = client.convert(scene, system).scene
    assert other["method"]["name"] == "adaptive"
    with client.create(scene) as one, client.create(other) as two:
        other["initial"] = {name: two.step(1)[name] for name in other["initial"]}
        there = client.convert(one._resolved(), "rigid_body").scene
        there["initial"] = {name: one.step(1)[name] for name in ("Q", "M")}
    home = client.convert(other, "rigid_body").scene
    for name in ("Q", "M"):
        np.testing.assert_allclose(array(home, name), there["initial"][name], atol=1e-11)


def test_velocity_and_generator(client):
    scene = scenes.frame(2, 5)
    velocity, generator = (client.convert(scene, to).blocks for to in ("velocity", "angular_velocity"))
    np.testing.assert_allclose(velocity["Qdot"] * scene["inertia"], scene["initial"]["S"], atol=1e-14)
    np.testing.assert_allclose(velocity["Q"] @ generator["U"], velocity["Qdot"], atol=1e-13)
    np.testing.assert_array_equal(generator["U"], -generator["U"].T)


def test_interpolation_weights_are_symmetric(client):
    """Checks [RB] (7.15) and (7.20), and with (7.16) and (7.21) the way back to P."""
    scene = scenes.free(4)
    b = client.convert(scene, "interpolation").blocks
    inertia = np.diag(scene["inertia"])
    for weight in ("Sigma", "Lambda_k"):
        np.testing.assert_allclose(b[weight], b[weight].T, atol=1e-13)
    np.testing.assert_allclose(b["Q"] @ b["Sigma"] - b["Q_prev"] @ inertia, b["P"], atol=1e-13)
    np.testing.assert_allclose(b["Q"] @ b["Lambda_k"] + b["Q_next"] @ inertia, b["P"], atol=1e-13)


def test_epsilon_makes_room_for_any_momentum(client):
    scene = scenes.free(4)
    big = {**scene, "initial": {"Q": scene["initial"]["Q"], "M": 1e6 * scene["initial"]["M"]}}
    converted = client.convert(big, "symmetric_rigid_body")
    assert converted.scene["epsilon"] < 1e-5 and converted.margins["S_M"] >= 1
    with pytest.raises(stiefel.InvalidArgument, match="S_M") as refused:
        client.convert(big, "symmetric_rigid_body", epsilon=1)
    assert refused.value.reason == "OUTSIDE_DOMAIN"
    norm = np.linalg.norm(big["initial"]["M"], 2)
    assert float(refused.value.metadata["value"]) == pytest.approx(norm, rel=1e-12)
    assert refused.value.metadata["bound"] == "2"


@pytest.mark.parametrize("N", [3, 4, 5, 8])
@pytest.mark.parametrize("system", ["moser_veselov_pair", "discrete_stiefel"])
def test_a_step_without_a_rotation_has_no_pair(client, system, N):
    scene = {**scenes.free(N), "step": 1e3}
    with pytest.raises(stiefel.InvalidArgument) as refused:
        client.convert(scene, system)
    assert refused.value.reason == "OUTSIDE_DOMAIN"
    assert float(refused.value.metadata["value"]) > float(refused.value.metadata["bound"]) > 0


def test_the_margin_is_the_distance_to_the_edge(client):
    scene = scenes.free(4)
    scene["initial"]["M"] = 1.9 * scene["initial"]["M"] / np.linalg.norm(scene["initial"]["M"], 2)
    converted = client.convert(scene, "symmetric_rigid_body", epsilon=1)
    assert converted.margins["S_M"] == pytest.approx(0.1, rel=1e-9)
    assert client.convert(converted.scene, "rigid_body").margins["S"] == pytest.approx(0.1, rel=1e-9)


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
        client.convert(scene, to)
