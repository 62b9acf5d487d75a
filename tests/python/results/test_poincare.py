"""Poincaré sections against planes on which the crossings are known: Joachimsthal's integral of an ellipsoid, and the curves of
a body in which an ellipsoid of energy cuts a sphere of momentum."""
import numpy as np
import pytest

import stiefel

SQUARES = np.array([1.0, 4.0, 9.0])
ELLIPSOID = {"system": "ellipsoid", "inertia": SQUARES, "step": 0.05, "method": {"name": "variational", "order": 8},
             "initial": {"q": [[0.6, 0.8, 0]], "qdot": [[-0.4, 0.3, 0.5]]}}
EQUATOR = {"q": [0, 0, 1]}


def test_joachimsthal_s_integral_is_constant_on_the_section(client):
    with client.create(ELLIPSOID) as session:
        section = session.poincare(EQUATOR, to=20_000, coordinates=[
            lambda s: (s["q"]**2 @ (1 / SQUARES)) * (s["qdot"]**2).sum(axis=1), {"qdot": [0, 0, 1]}], fields=["q", "qdot"])
        events = session.events(20_000, events={"field": "q", "coefficients": [0, 0, 1], "direction": "rising"}, fields=["q", "qdot"])
    assert section.count == events.count > 100 and (section.time == events.time).all()
    assert section.run_status.outcome == "REACHED"
    assert np.ptp(section.points[:, 0]) < 1e-10 * section.points[0, 0] and (section.points[:, 1] > 0).all()
    assert abs(section.residual).max() < 1e-15 and (section.residual == section["q"][:, 2]).all()


def test_a_section_has_a_level_a_direction_and_slices(client):
    with client.create(ELLIPSOID) as session:
        up, down, both = (session.poincare(EQUATOR, to=3000, level=0.1, direction=way, coordinates=[EQUATOR, {"q": [1, 0, 0], "qdot": [0, 2, 0]}])
                          for way in ("rising", "falling", "both"))
        nothing = session.poincare(EQUATOR, to=3000, level=2, coordinates=[EQUATOR, lambda s: s["q"][:, 0]])
    assert sorted([*up.time, *down.time]) == list(both.time) and min(up.count, down.count) > 10
    np.testing.assert_allclose(both.points[:, 0], 0.1, atol=1e-15)
    assert (both.points[:, 1] == both["q"][:, 0] + 2 * both["qdot"][:, 1]).all()
    part = both[3:9:2]
    assert isinstance(part, stiefel.Section) and (part.points == both.points[3:9:2]).all() and len(part.residual) == 3
    assert [one.points.shape for one in both[:2]] == [(1, 2), (1, 2)]
    assert nothing.count == 0 and nothing.points.shape == (0, 2) and nothing.residual.shape == (0,)
    assert "Section" in repr(both) and "crossings" in repr(both)


@pytest.mark.parametrize("wrong, field", [
    ({"section": {}}, "section"), ({"section": [1, 0, 0]}, "section"), ({"section": {"q": [0, 1]}}, "section: 2 numbers"),
    ({"section": {"q": [0, 0, 1], "qdot": [1, 0]}}, "section: 2 numbers"),
    ({"section": {"q": [0, 0, 1], "z": [1, 0, 0]}}, "section: z: [^;]*$"), ({"section": {"p": "up"}}, "section.p"),
    ({"direction": "up"}, "direction"), ({"level": "high"}, "level"), ({"coordinates": [{"q": [1, 2]}]}, r"coordinates\[0\].q"),
    ({"coordinates": 3}, "coordinates: 3"), ({"coordinates": [{"z": [1]}]}, "coordinates: z: "), ({"fields": ["z"]}, r"fields\[0\]"),
    ({"coordinates": [3]}, r"coordinates\[0\]"), ({"coordinates": [lambda s: 1.0]}, r"coordinates\[0\]")])
def test_what_is_no_section_is_refused(client, wrong, field):
    with client.create(ELLIPSOID) as session, pytest.raises(stiefel.InvalidArgument, match=f"^{field}"):
        session.poincare(**{"section": EQUATOR, "to": 500, **wrong})
