"""A member of an ensemble has the bits of the same scene alone, whatever the other members are."""
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import scenes
import stiefel

fewer = settings(max_examples=max(1, settings.default.max_examples // 4))  # each example makes many sessions


def members_of(fields, count):
    """Returns the bytes of the fields of each member."""
    return [{name: values[k].tobytes() for name, values in fields.items()} for k in range(count)]


@fewer
@given(data=st.data())
def test_every_member_has_the_bits_that_it_has_alone(client, pair, data):
    alone, together = data.draw(scenes.ensembles(pair))
    ks = data.draw(st.lists(st.integers(0, 100), min_size=1, max_size=3))
    with client.create(together) as ensemble:
        reached = {k: members_of(ensemble.step(to=k).fields, len(alone)) for k in ks}
    for index, scene in enumerate(alone):
        with client.create(scene) as session:
            for k in ks:
                own = {name: values.tobytes() for name, values in session.step(to=k).fields.items()}
                assert reached[k][index] == own, (index, k)


@fewer
@given(data=st.data())
def test_the_diagnosis_is_of_the_worst_member(client, pair, data):
    alone, together = data.draw(scenes.ensembles(pair))
    with client.create(together) as ensemble:
        worst = {i.name: (i.drift, i.member) for i in ensemble.diagnose(to=50).invariants}
    drifts = []
    for scene in alone:
        with client.create(scene) as session:
            drifts.append({i.name: i.drift for i in session.diagnose(to=50).invariants})
    for name, (drift, member) in worst.items():
        assert drift == max(own[name] for own in drifts) == drifts[member][name], name


@fewer
@given(data=st.data())
def test_one_wrong_member_is_named(client, pair, data):
    alone, together = data.draw(scenes.ensembles(pair))
    wrong = data.draw(st.integers(0, len(alone) - 1))
    block = together["initial"][sorted(together["initial"])[0]]
    block[wrong] = np.nan
    with pytest.raises(stiefel.InvalidArgument, match=rf"member {wrong}\b"):
        client.create(together)
