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
                      max(getattr(point, error), tradeoff.setup.reference_error))
                     for point in tradeoff.points if point.outcome == stiefel.Outcome.REACHED}
    title = axes.get_title(loc="left")
    assert tradeoff.setup.machine in title and "stiefel" in title and "2 timed runs" in title
    plt.close(axes.figure)


def test_the_front_is_in_front(tradeoff):
    axes = tradeoff.plot()
    known = tradeoff.setup.reference_error
    front = max(axes.lines, key=lambda line: line.get_zorder())
    assert [tuple(point) for point in front.get_xydata()] == [(p.work, max(p.error, known)) for p in tradeoff.front]
    plt.close(axes.figure)
    axes = tradeoff.plot(cost="time", error="drift")
    front = max(axes.lines, key=lambda line: line.get_zorder()).get_xydata()
    assert (np.diff(front[:, 0]) >= 0).all() and (np.diff(front[:, 1]) < 0).all()
    plt.close(axes.figure)


def test_the_diagram_refuses_another_cost(tradeoff):
    with pytest.raises(ValueError, match="cost: 'money'"):
        tradeoff.plot(cost="money")


def test_an_error_of_the_server_is_an_exception_of_this_package(client):
    with pytest.raises(stiefel.InvalidArgument, match="horizon"):
        client.tradeoff(SCENE, horizon=-1.0)
