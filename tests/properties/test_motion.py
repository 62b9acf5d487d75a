"""What the catalogue declares about a method holds on every scene."""
import numpy as np
from hypothesis import given, strategies as st

import scenes
import stiefel

STEPS = 64


def rounding(scene):
    """Returns 100 u sqrt(steps) times 10, a bound of the condition numbers (maps are solved at h ||Omega|| <= 1/8)."""
    return 100 * scenes.unit(scene) * STEPS**0.5 * 10


@given(data=st.data())
def test_what_is_kept_is_kept(client, pair, data):
    """Invariants and orthogonality are kept to rounding if they are declared exact, else to the method's error."""
    scene = data.draw(scenes.scenes(pair))
    declared = scenes.preserved(pair)
    with client.create(scene) as session:
        diagnosis = session.diagnose(to=STEPS)
        assert diagnosis.outcome is stiefel.Outcome.REACHED
        for invariant in diagnosis.invariants:
            family = invariant.name.partition("[")[0]
            assert invariant.conservation == declared[family], invariant.name
            exact = invariant.conservation == stiefel.Conservation.EXACT
            assert invariant.drift <= (rounding(scene) if exact else 1e-2), invariant.name
        if declared.get("orthogonality") == stiefel.Conservation.EXACT and diagnosis.orthogonality is not None:
            assert diagnosis.orthogonality <= rounding(scene)


@given(data=st.data())
def test_forth_and_back(client, pair, data):
    """A reversible method undoes its steps. Discrete systems are left out because their step is part of their state,
    and single precision because its frames may be too far off orthogonality to start from."""
    scene = data.draw(scenes.scenes(pair._replace(in_float=False)))
    if not any(method.reversible for method in scenes.catalogue().methods if method.name == pair.method):
        return
    with client.create(scene) as session:
        start, there = session.step(to=0), session.step(to=STEPS)
        back = dict(session.scene, step=-scene["step"], initial=there.fields)
    with client.create(back) as session:
        home = session.step(to=STEPS)
    for name in start.fields:
        np.testing.assert_allclose(home[name], start[name], rtol=0, atol=10 * rounding(scene))
