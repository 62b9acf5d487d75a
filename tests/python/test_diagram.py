"""The answer of MeasureTradeoff and its picture."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pytest

import stiefel

SCENE = {"system": "rigid_body", "step": 0.2, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}}


@pytest.fixture(scope="module")
def tradeoff(client):
    return client.tradeoff(SCENE, horizon=4.0, budget=3e8, repeats=2)


def test_a_point_knows_its_larger_error(tradeoff):
    for point in tradeoff.points:
        assert point.error == max(point.attitude_error, point.momentum_error)
        assert point.method in point.family and point.arithmetic in point.family


@pytest.mark.parametrize("cost", ["work", "time"])
@pytest.mark.parametrize("error", ["error", "attitude_error", "momentum_error", "drift"])
def test_the_diagram_shows_every_point(tradeoff, cost, error):
    axes = tradeoff.plot(cost=cost, error=error)
    assert axes.get_xscale() == axes.get_yscale() == "log"
    drawn = {tuple(line.get_xydata()[0]) for line in axes.lines if len(line.get_xdata()) == 1}
    assert drawn == {(point.work if cost == "work" else np.median(point.cpu_seconds_per_second),
                      max(getattr(point, error), tradeoff.reference_error))
                     for point in tradeoff.points if point.outcome == stiefel.Outcome.REACHED}
    title = axes.get_title(loc="left")
    assert tradeoff.machine in title and "stiefel" in title and "2 timed runs" in title
    plt.close(axes.figure)


def test_the_front_is_in_front(tradeoff):
    axes = tradeoff.plot()
    known = tradeoff.reference_error
    front = max(axes.lines, key=lambda line: line.get_zorder())
    assert [tuple(point) for point in front.get_xydata()] == [(p.work, max(p.error, known)) for p in tradeoff.front]
    plt.close(axes.figure)
    axes = tradeoff.plot(cost="time", error="drift")
    front = max(axes.lines, key=lambda line: line.get_zorder()).get_xydata()
    assert (np.diff(front[:, 0]) >= 0).all() and (np.diff(front[:, 1]) < 0).all()
    plt.close(axes.figure)


def test_a_data_frame_has_a_row_for_each_point(tradeoff):
    pytest.importorskip("pandas")
    frame = tradeoff.to_dataframe()
    assert len(frame) == len(tradeoff.points) and frame.attrs["horizon"] == 4.0 and frame.attrs["machine"] == tradeoff.machine
    for row, point in zip(frame.itertuples(), tradeoff.points):
        assert (row.method, row.order, row.work, row.drift_of, row.outcome) == (point.method, point.order, point.work, point.drift_of, "REACHED")
        assert row.error == max(point.attitude_error, point.momentum_error) and row.front == (point in tradeoff.front)
        assert row.cpu_seconds_per_second == np.median(point.cpu_seconds_per_second) or not point.cpu_seconds_per_second
    assert frame["error"].dtype == float and frame["front"].sum() == len(tradeoff.front)


def test_a_section_is_drawn_by_its_points(client):
    scene = {"system": "ellipsoid", "inertia": [1, 2, 3], "step": 0.05, "members": 2, "method": {"name": "variational"},
             "initial": {"q": [[[1, 0, 0]], [[0, 1, 0]]], "qdot": [[[0, 1, 0.3]], [[1, 0, 0.5]]]}}
    with client.create(scene) as session:
        section = session.poincare({"q": [0, 0, 1]}, to=500, coordinates=[{"q": [1, 0, 0]}, {"qdot": [1, 0, 0]}, lambda s: s.time])
        bare = session.poincare({"q": [0, 0, 1]}, to=500)
    axes = section.plot(x=2, y=0, markersize=4)
    assert len(axes.lines) == 2 and axes.lines[0].get_markersize() == 4
    for member, line in enumerate(axes.lines):
        np.testing.assert_array_equal(line.get_xydata(), section.points[section.member == member][:, [2, 0]])
    assert section.plot(axes) is axes and len(axes.lines) == 4
    with pytest.raises(ValueError, match="x, y: 0, 1: must be columns of points, of which there are 0"):
        bare.plot()
    plt.close(axes.figure)


def test_a_spectrum_is_drawn_over_time(client):
    with client.create({**SCENE, "method": {"name": "variational"}}) as session:
        spectrum = session.lyapunov(to=4000, every=500, count=2)
    axes = spectrum.plot()
    curves = [line for line in axes.lines if str(line.get_label()).startswith("$")]
    assert [line.get_label() for line in curves] == [r"$\lambda_{1}$", r"$\lambda_{2}$"]
    assert axes.get_title(loc="left") == str(spectrum.verdict)
    for k, line in enumerate(curves):
        np.testing.assert_array_equal(line.get_xydata(), np.stack([spectrum.times, spectrum.history[:, k]], axis=1))
    bars = axes.collections[0].get_segments()[0]
    np.testing.assert_allclose(bars[:, 1], spectrum.exponents[0] + spectrum.errors[0] * np.array([-1, 1]))
    plt.close(axes.figure)


def test_the_diagram_refuses_another_cost(tradeoff):
    with pytest.raises(ValueError, match="cost: 'money'"):
        tradeoff.plot(cost="money")


def test_an_error_of_the_server_is_an_exception_of_this_package(client):
    with pytest.raises(stiefel.InvalidArgument, match="horizon"):
        client.tradeoff(SCENE, horizon=-1.0)
