"""A momentum of any size keeps its digits in every system that represents epsilon M by a P."""
import numpy as np
from hypothesis import given, strategies as st

import scenes
import stiefel
from stiefel.scenes import to_array, to_message

STEPS = 32
# The error of two changes of variables in up to 5 dimensions, each with about ten roundings of numbers near 1.
ROUNDING = 64 * 2**-53
# 100 u sqrt(steps) for condition numbers of up to 10.
DRIFT = 1000 * 2**-53 * STEPS**0.5


def has_epsilon(pair):
    system = next(s for s in scenes.catalogue().systems if s.name == pair.system)
    return any(field.name == "epsilon" for field in system.fields)


@st.composite
def bodies(draw):
    """Draws bodies with M from 1e-300 to 1e150 and a step proportional to 1/M. Lambda is scaled, too, where the step
    would otherwise leave the range 1e-153 to 1e153."""
    scene = draw(scenes.scenes(scenes.Pair("rigid_body", "variational", 2)))
    power = draw(st.integers(-300, 150))
    momentum, inertia = 10.0**power, 10.0**(power // 2 if power < -140 else 0)
    scene["initial"]["M"] = scene["initial"]["M"] * momentum
    scene["inertia"] = scene["inertia"] * inertia
    scene["step"] *= inertia / momentum
    return scene


def moving(scene):
    return np.any(scene["initial"]["M"])


@given(data=st.data())
def test_there_and_back_m_has_its_digits(client, pair, data):
    if not has_epsilon(pair):
        return
    given_scene = data.draw(bodies())
    there = client.convert(given_scene, pair.system)
    assert all(margin > 0 for margin in there.margins.values())
    assert there.margins["1/condition of M"] > 0.2 if moving(given_scene) else there.scene["epsilon"] == 1
    home = to_message(client.convert(there.scene, "rigid_body").scene).initial
    for name, block in given_scene["initial"].items():
        np.testing.assert_allclose(to_array(home[name]), block, rtol=0, atol=ROUNDING * max(np.abs(block).max(), 1e-310))


@given(data=st.data())
def test_what_is_kept_is_kept_at_every_scale(client, pair, data):
    if not has_epsilon(pair):
        return
    scene = dict(client.convert(data.draw(bodies()), pair.system).scene)
    if pair.method:
        scene["method"] = {"name": pair.method} | ({"order": pair.order} if pair.method == "variational" else {})
    with client.create(scene) as session:
        diagnosis = session.diagnose(to=STEPS)
    for invariant in diagnosis.invariants:
        if invariant.conservation == stiefel.Conservation.EXACT:
            assert invariant.drift <= DRIFT, invariant.name


@given(data=st.data())
def test_a_given_epsilon_costs_what_the_margin_says(client, pair, data):
    if not has_epsilon(pair):
        return
    scene, power = data.draw(scenes.scenes(scenes.Pair("rigid_body", "variational", 2))), data.draw(st.integers(-20, -1))
    M = scene["initial"]["M"] = scene["initial"]["M"] * 10.0**power / 4
    there = client.convert(scene, pair.system, epsilon=1)
    if not moving(scene):
        return
    home = to_message(client.convert(there.scene, "rigid_body").scene).initial["M"]
    off = ROUNDING / there.margins["1/condition of M"] * np.abs(M).max()
    np.testing.assert_allclose(to_array(home), M, rtol=0, atol=off)
