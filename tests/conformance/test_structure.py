"""Diagnose: two-forms, the Dirac bracket, how far a step is from symplectic, and drift in any units."""
import numpy as np
import pytest

import scenes
import stiefel


def test_the_canonical_dirac_bracket_is_skew_and_a_derivation(client):
    scene = client.convert(scenes.free(3), system="symmetric_rigid_body").scene
    random = np.random.default_rng(1)
    F, G, H = [[(random.standard_normal((3, 3)), random.standard_normal((3, 3)))] for _ in range(3)]
    with client.create(scene) as session:
        Q, P = session.step(0)["Q"], session.step(0)["P"]
        FG, GF, FH, FGH = session.diagnose(
            0, invariants=["energy"], dirac_brackets=[(F, G), (G, F), (F, H), (F, G + H)]).dirac_brackets
    value = lambda f: np.sum(f[0][0] * Q) + np.sum(f[0][1] * P)
    assert FG == pytest.approx(-GF, rel=1e-12)
    assert FGH == pytest.approx(FG * value(H) + FH * value(G), rel=1e-12)


@pytest.mark.parametrize("scene, symplectic", [
    (scenes.free(4), True), (scenes.rigid_body(), True), (scenes.moser_veselov(), True), (scenes.frame(2, 5), True),
    (scenes.free(3, method="exact"), True), (scenes.free(3, method="splitting"), True),
    (scenes.free(4, method="rk4"), False), (scenes.free(4, method="munthe_kaas4"), False),
    (scenes.frame(2, 5, method="rk4"), False),
], ids=["variational", "3D", "moser_veselov", "frames", "exact", "splitting", "rk4", "munthe_kaas4",
        "frames rk4"])
def test_whether_a_step_is_symplectic(client, scene, symplectic):
    with client.create({**scene, "step": 0.1}) as session:
        defect = session.diagnose(5, invariants=["energy"], symplectic=True).symplectic_defect
    assert defect < 1e-10 if symplectic else defect > 1e-9


@pytest.mark.parametrize("form, first, fault", [
    ("Omega_gl", {"Q": np.zeros((3, 3)), "M": np.zeros((3, 3))}, r"forms\[0\].form: Omega_gl: is not a two-form of rigid_body"),
    ("omega", {"Q": np.zeros((3, 3))}, r"forms\[0\].first.M: absent"),
    ("omega", {"Q": np.zeros((2, 3)), "M": np.zeros((3, 3))}, r"forms\[0\].first.Q: 2 x 3: must be given"),
    ("omega", {"Q": np.zeros((3, 3)), "M": np.zeros((3, 3)), "P": np.zeros((3, 3))}, r"first.P: 3 x 3: the blocks are Q, M"),
    ("omega", {"Q": np.eye(3), "M": np.zeros((3, 3))}, r"forms\[0\].first: off by .* must be tangent"),
])
def test_what_is_no_tangent_vector_is_refused(client, form, first, fault):
    zero = {"Q": np.zeros((3, 3)), "M": np.zeros((3, 3))}
    with client.create(scenes.rigid_body()) as session:
        with pytest.raises(stiefel.InvalidArgument, match=fault):
            session.diagnose(0, forms=[(form, first, zero)])


def test_a_system_without_a_form_says_so(client):
    scene = client.convert(scenes.free(4), system="mclachlan_scovel").scene
    with client.create(scene) as session:
        with pytest.raises(stiefel.InvalidArgument, match="no two-form"):
            session.diagnose(0, symplectic=True)


def test_describe_lists_the_forms(client):
    forms = {system.name: [form.name for form in system.forms] for system in client.describe().systems}
    assert forms["rigid_body"] == ["omega"] and forms["stiefel"] == ["omega_pairs", "omega_cotangent"]


def test_an_ensemble_has_neither_forms_nor_a_symplectic_test(client):
    with client.create(scenes.BIT_SCENES["ensemble"]) as session:
        for asked in ({"forms": [("omega", {}, {})]}, {"symplectic": True}):
            with pytest.raises(stiefel.InvalidArgument, match=r"(forms|symplectic_test): 5 members: the scene must have no"):
                session.diagnose(0, **asked)


def test_a_function_of_another_shape_names_its_place(client):
    scene, zero = client.convert(scenes.free(3), system="symmetric_rigid_body").scene, np.zeros((3, 3))
    with client.create(scene) as session:
        with pytest.raises(stiefel.InvalidArgument, match=r"dirac_brackets\[0\].second\[1\].B: 3 x 2"):
            session.diagnose(0, dirac_brackets=[([(zero, zero)] * 2, [(zero, zero), (zero, zero[:, :2])])])


@pytest.mark.parametrize("size", [1e-150, 1e-100, 1e100, 1e150])
def test_drift_is_a_number_where_the_invariant_is_none(client, size):
    """Invariants are powers of M up to the fifth. Those beyond the range of doubles are left out, and the others drift
    as in other units."""
    scene = scenes.free(5, method="rk4")
    scene["initial"]["M"] = size * scene["initial"]["M"]
    scene["step"] /= size
    with client.create(scene) as session:
        drifts = {invariant.name: invariant.drift for invariant in session.diagnose(to=100).invariants}
    plain = scenes.free(5, method="rk4")
    with client.create(plain) as session:
        expected = {invariant.name: invariant.drift for invariant in session.diagnose(to=100).invariants}
    assert "energy" in drifts and len(drifts) > len(expected) / 2
    for name, drift in drifts.items():
        assert drift == pytest.approx(expected[name], abs=1e-13), name
