"""Poincaré sections against planes on which the crossings are known: Joachimsthal's integral of an ellipsoid, and the curves of
a body in which an ellipsoid of energy cuts a sphere of momentum."""
import numpy as np
import pytest

import stiefel

I = np.array([1.0, 2.0, 3.0])
TOP = {"system": "rigid_body", "step": 0.05, "body": {"moments": I, "angular_velocity": [0.9, 0.2, 0.4]}}
SQUARES = np.array([1.0, 4.0, 9.0])
ELLIPSOID = {"system": "ellipsoid", "inertia": SQUARES, "step": 0.05, "method": {"name": "variational", "order": 8},
             "initial": {"q": [[0.6, 0.8, 0]], "qdot": [[-0.4, 0.3, 0.5]]}}
EQUATOR = {"q": [0, 0, 1]}


@pytest.mark.parametrize("method", [{"name": "exact"}, {"name": "preprocessed_variational", "order": 10}], ids=lambda m: m["name"])
def test_a_body_crosses_a_plane_where_energy_and_momentum_say(client, method):
    """On m_2 = 0, energy and |m| fix m_1^2 and m_3^2."""
    m = I * TOP["body"]["angular_velocity"]
    energy, square = np.sum(m**2 / I) / 2, np.sum(m**2)
    first, third = np.linalg.solve([[1 / I[0], 1 / I[2]], [1, 1]], [2 * energy, square])
    with client.create({**TOP, "method": method}) as session:
        section = session.poincare({"angular_velocity": [0, 1, 0]}, to=20_000, direction="both",
                                   coordinates=[{"angular_velocity": [1, 0, 0]}, {"M": [[0, -0.5, 0], [0.5, 0, 0], [0, 0, 0]]}])
    assert section.count > 100 and section.points.shape == (section.count, 2)
    np.testing.assert_allclose((section.points * [I[0], 1])**2, np.broadcast_to([first, third], section.points.shape), rtol=1e-12)
    rate = (I[2] - I[0]) / I[1] * np.sqrt(first * third) / (I[0] * I[2])  # of omega_2
    assert (abs(section.residual) <= 2**-52 * (1 + section.time * rate)).all()  # the rounding of the time


def test_joachimsthal_s_integral_is_constant_on_the_section(client):
    with client.create(ELLIPSOID) as session:
        section = session.poincare(EQUATOR, to=20_000, coordinates=[
            lambda s: (s["q"]**2 @ (1 / SQUARES)) * (s["qdot"]**2).sum(axis=1), {"qdot": [0, 0, 1]}], fields=["q", "qdot"])
        events = session.events(20_000, {"field": "q", "coefficients": [0, 0, 1], "direction": "rising"}, fields=["q", "qdot"])
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


def test_a_plane_in_the_whole_state_is_crossed_when_the_great_circle_says(client):
    """q = a cos t + b sin t: with 0.6 q_1 - 0.8 qdot_2 + 0.3 q_3 the amplitude and the phase follow from a and b."""
    a, b = np.array([0.6, 0.8, 0]), np.array([-0.48, 0.36, 0.8])
    circle = {"system": "ellipsoid", "inertia": [1, 1, 1], "step": 0.02, "method": {"name": "variational", "order": 8}, "initial": {"q": [a], "qdot": [b]}}
    form, level = {"q": [0.6, 0, 0.3], "qdot": [0, -0.8, 0]}, 0.2
    cosine, sine = 0.6 * a[0] + 0.3 * a[2] - 0.8 * b[1], 0.6 * b[0] + 0.3 * b[2] + 0.8 * a[1]
    phase, width = np.arctan2(sine, cosine), np.arccos(level / np.hypot(cosine, sine))
    expected = phase - width + 2 * np.pi * np.arange(40)  # rising
    with client.create(circle) as session:
        section = session.poincare(form, to=10_000, level=level, coordinates=[form])
        events = session.events(10_000, {"field": "qdot", "coefficients": [0, -0.8, 0], "plus": {"q": [0.6, 0, 0.3]}, "level": level, "direction": "rising"})
    expected = expected[(expected > 0) & (expected <= 200)]
    np.testing.assert_allclose(section.time, expected, rtol=0, atol=1e-10)
    np.testing.assert_allclose(events.time, expected, rtol=0, atol=1e-10)
    assert abs(section.residual).max() < 1e-14 and (section.points[:, 0] - level == section.residual).all()
    assert set(section.fields) == {"q", "qdot"}


def test_the_members_of_an_ensemble_are_on_one_section(client):
    q, v = np.array(ELLIPSOID["initial"]["q"][0]), np.array(ELLIPSOID["initial"]["qdot"][0])
    both = {**ELLIPSOID, "members": 2, "initial": {"q": [q, q], "qdot": [v, 2 * v]}}
    with client.create(both) as together, client.create(ELLIPSOID) as alone:
        pair = together.poincare(EQUATOR, to=2000, coordinates=[{"q": [1, 0, 0]}])
        one = alone.poincare(EQUATOR, to=2000, coordinates=[{"q": [1, 0, 0]}])
    assert set(pair.member) == {0, 1} and (pair.points[pair.member == 0] == one.points).all()


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


def test_zeros_are_rows_of_a_data_frame(client):
    pytest.importorskip("pandas")
    with client.create({**ELLIPSOID, "members": 2, "initial": {name: [block, block] for name, block in ELLIPSOID["initial"].items()}}) as session:
        section = session.poincare(EQUATOR, to=2000, coordinates=[{"q": [1, 0, 0]}])
    frame = section.to_dataframe()
    assert list(frame) == ["event", "step", "fraction", "time", "member", "q[0]", "q[1]", "q[2]", "point[0]", "residual"]
    assert (frame["time"] == section.time).all() and (frame["q[1]"] == section["q"][:, 1]).all() and (frame["point[0]"] == section.points[:, 0]).all()
