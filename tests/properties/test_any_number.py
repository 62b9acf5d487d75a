"""Whatever number stands anywhere in a scene, the answer has finite numbers, or is a refusal that names a field."""
import copy
import math

import numpy as np
from hypothesis import given, strategies as st

import scenes
import stiefel
from stiefel._scene import to_message

EDGES = [0.0, -0.0, -1.0, 5e-324, 2.0**-1022, 1e-300, 1e-160, 1e-150, 1e-20, 1 + 2**-52, 1e6, 1e20, 1e150, 1e154,
         1e160, 1e300, 1.7976931348623157e308, math.inf, math.nan]
numbers = st.sampled_from(EDGES + [-x for x in EDGES if x > 0]) | st.floats()


def places(scene):
    """Yields every number of a scene that can be changed, with a function that sets it."""
    yield "step", lambda s, x: setattr(s, "step", x)
    if scene.HasField("epsilon"):
        yield "epsilon", lambda s, x: setattr(s, "epsilon", x)
    if scene.HasField("parameter"):
        yield "parameter", lambda s, x: setattr(s, "parameter", x)
    for field in ("inertia", "inertia_u", "inertia_v"):
        for k in range(len(getattr(scene, field))):
            yield f"{field}[{k}]", lambda s, x, field=field, k=k: getattr(s, field).__setitem__(k, x)
    for name in sorted(scene.initial):  # sorted because a map has no order
        for k in range(len(scene.initial[name].values)):
            yield f"{name}[{k}]", lambda s, x, name=name, k=k: s.initial[name].values.__setitem__(k, x)


def scaled(scene, name, factor):
    """Multiplies a whole block, or the inertia, by a factor."""
    values = scene.inertia if name == "inertia" else scene.initial[name].values
    values[:] = [x * factor for x in values]


def answers(client, scene):
    try:
        session = client.create(scene)
    except stiefel.InvalidArgument as refused:
        assert refused.violations and all(v.field and v.description for v in refused.violations)
        return
    with session:
        for k in (1, 3):
            state = session.step(to=k, fields=[name.replace("SEQUENCE", "ZXZ") for name in offered(session)])
            for name, values in state.fields.items():
                assert np.isfinite(values).all(), (k, name, values, state.run_status)
        diagnosis = session.diagnose(to=3)
        for invariant in diagnosis.invariants:  # a power of M may exceed the range of doubles, but its drift must not
            assert not np.isnan(invariant.value) and np.isfinite(invariant.drift), invariant
        assert diagnosis.orthogonality is None or np.isfinite(diagnosis.orthogonality)
        assert not np.isnan(diagnosis.domain.h_omega)  # it may be infinite for numbers near the largest


def offered(session):
    """Returns the fields of the session's scene. Some exist only in three dimensions, or if they were given."""
    try:
        session.step(to=0, fields=["no field"])
    except stiefel.InvalidArgument as refused:
        return refused.violations[0].description.partition("must be one of ")[2].partition(";")[0].partition(" (")[0].split(", ")


@given(data=st.data())
def test_a_number(client, pair, data):
    scene = to_message(data.draw(scenes.scenes(pair)))
    _, put = data.draw(st.sampled_from(list(places(scene))))
    changed = copy.deepcopy(scene)
    put(changed, data.draw(numbers))
    answers(client, changed)


@given(data=st.data())
def test_the_fields_are_those_of_describe(client, pair, data):
    described = {field.name for s in scenes.catalogue().systems if s.name == pair.system for field in s.fields}
    with client.create(data.draw(scenes.scenes(pair))) as session:
        assert set(offered(session)) <= described


@given(data=st.data())
def test_other_units(client, pair, data):
    scene = to_message(data.draw(scenes.scenes(pair)))
    names = (["inertia"] if scene.inertia else []) + sorted(scene.initial)
    scaled(scene, data.draw(st.sampled_from(names)), data.draw(st.sampled_from([2.0**k for k in (-1070, -1000, -500, -30, 30, 500, 1000)])))
    answers(client, scene)
