"""A conversion to another system and back gives the same motion, wherever the conversion exists."""
import numpy as np
from hypothesis import given, strategies as st

import scenes
import stiefel
from stiefel._wire.arrays import to_array
from stiefel._scene import to_message

# The error of a conversion through (Q, M) or (Q, S), which solves J and J_D: condition numbers of up to 1e3.
ROUNDING = 1e3 * 100 * 2**-53


def blocks(scene):
    """The initial blocks; of a costate, which is defined up to BQ with a symmetric B, QᵀP − PᵀQ."""
    all = {name: to_array(block) for name, block in to_message(scene).initial.items()}
    if scene["system"] == "stiefel_costate":
        momentum = all["Q"].T @ all.pop("P")
        all["M"] = momentum - momentum.T
    return all


@given(data=st.data())
def test_there_and_back(client, pair, data):
    given = data.draw(scenes.scenes(pair))
    target = data.draw(st.sampled_from([system.name for system in scenes.catalogue().systems]))
    try:
        there = client.convert(given, system=target)
    except stiefel.InvalidArgument as refused:
        assert refused.reason == "OUTSIDE_DOMAIN" or refused.violations
        return
    assert there.scene["system"] == target and there.scene["step"] == given["step"]
    assert all(margin > 0 for margin in there.margins.values())
    with client.create(given) as session:
        start = blocks(session.scene)
        options = {name: session.scene[name] for name in ("epsilon", "parameter") if name in session.scene}
    home = blocks(client.convert(there.scene, system=given["system"], **options).scene)
    for name in start.keys() & home.keys():
        np.testing.assert_allclose(home[name], start[name], rtol=0, atol=ROUNDING, err_msg=f"{name} by {target}")
    assert start.keys() & home.keys()


@given(data=st.data())
def test_the_energy_is_the_same(client, pair, data):
    """The energy is the same in both variables, wherever the conversion exists."""
    given = data.draw(scenes.scenes(pair))
    target = data.draw(st.sampled_from(["rigid_body", "right_rigid_body", "symmetric_rigid_body", "mclachlan_scovel",
                                        "stiefel", "stiefel_costate", "stiefel_momentum"]))
    try:
        there = client.convert(given, system=target).scene
    except stiefel.InvalidArgument:
        return
    here = energies(client, given)
    rounding = 1e5 * scenes.unit(given)  # in float, each system rounds its own blocks
    np.testing.assert_allclose(energies(client, there)[:len(here)], here, rtol=rounding, atol=rounding / 100)


def energies(client, scene):
    with client.create(scene) as session:
        return [i.value for i in session.diagnose(to=0).invariants if i.name == "energy"]
