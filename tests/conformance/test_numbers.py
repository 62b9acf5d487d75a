"""For numbers near the ends of the range of doubles, the reply has finite numbers or is a refusal."""
import numpy as np
import pytest

import scenes
import stiefel

E1 = np.eye(1, 3)


def test_a_field_that_overflows_is_refused(client):
    scene = {"system": "stiefel_costate", "inertia": [1e-150] * 3, "initial": {"Q": E1, "P": [[0, 1e200, 0]]}}
    with pytest.raises(stiefel.InvalidArgument, match=r"initial.P: max \|P\| = 1e\+200: max \|P\| must be"):
        client.create({**scene, "method": {"name": "rk4"}, "step": 0.01})


@pytest.mark.parametrize("scene", [
    {"system": "stiefel_costate", "inertia": [5e-324] * 3, "initial": {"Q": E1, "P": E1 / 4}},
    {"system": "rigid_body", "inertia": [5e-324] * 3, "initial": {"Q": np.eye(3), "M": scenes.M3}},
], ids=lambda scene: scene["system"])
def test_units_without_room_are_refused(client, scene):
    with pytest.raises(stiefel.InvalidArgument, match="inertia.*choose other units"):
        client.create({**scene, "method": {"name": "rk4"}, "step": 0.01})


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


@pytest.mark.parametrize("method", ["rk4", "munthe_kaas4"])
def test_rest_does_not_drift(client, method):
    """M = Q^-1 P - P^-1 Q - mu Lambda^2 is a difference of larger matrices and has their rounding errors."""
    mu, inertia = 1 / 4096, np.ones(3)
    w = mu / 2
    P = np.eye(3) * (w + np.sqrt(1 + w * w))
    scene = {"system": "parametric_rigid_body", "method": {"name": method}, "parameter": mu, "inertia": inertia,
             "initial": {"Q": np.eye(3), "P": P}, "step": 1 / 16}
    with client.create(scene) as session:
        assert max(invariant.drift for invariant in session.diagnose(to=64).invariants) < 1e-12
