"""Statistics, events and states at any times, against the samples that they are made of."""
import numpy as np
import pytest

import stiefel
from fake import Breaks

I, M_1, M_3 = (1.0, 2.0, 3.0), 0.5, 1.5
#: Circles the third axis: m_2 is 0 at the multiples of 2K/p.
TOP = {"system": "rigid_body", "method": {"name": "preprocessed_variational", "order": 10}, "step": 0.05,
       "body": {"moments": I, "angular_velocity": [M_1 / I[0], 0, M_3 / I[2]]}}
FLIP = {"field": "angular_velocity", "coefficients": [0, 1, 0]}
STATISTICS = ["last", "min", "max", "mean", "rms", "sign_changes", "drift"]


@pytest.fixture
def session(client):
    with client.create(TOP) as session:
        yield session


def ensemble(count, step=0.05, **method):
    rng = np.random.default_rng(1)
    return {**TOP, "step": step, "members": count, "method": {**TOP["method"], **method},
            "body": {"moments": I, "angular_velocity": rng.normal(size=3 * count).tolist()}}


def test_statistics_are_those_of_the_samples(session):
    edges, fractions = [-2, -0.5, 0, 0.25, 2], [0, 0.1, 0.5, 1]
    summary = session.summarize(1000, quantities={"M": [*STATISTICS, {"quantiles": fractions, "edges": edges}]}, start=3, every=7)
    run = session.trajectory(1000, start=3, every=7, fields="M")
    M, found = run["M"], summary["M"]
    assert summary.samples == run.samples and summary.last_step == 1000 and summary.ended_by == -1
    assert summary.outcome == summary.outcomes == stiefel.Outcome.REACHED
    assert (found["last"] == M[-1]).all() and (found["min"] == M.min(0)).all() and (found["max"] == M.max(0)).all()
    assert (found["drift"] == abs(M - session.step(0, fields="M")["M"]).max(0)).all()
    np.testing.assert_allclose(found["mean"], M.astype(np.longdouble).mean(0).astype(float), rtol=1e-15, atol=1e-17)
    np.testing.assert_allclose(found["rms"], np.sqrt((M.astype(np.longdouble)**2).mean(0)).astype(float), rtol=1e-15)
    assert (found["quantiles"] == np.moveaxis(np.quantile(M, fractions, axis=0), 0, -1)).all()
    for i, j in np.ndindex(3, 3):
        assert (found["histogram"][i, j] == np.histogram(M[:, i, j], edges)[0]).all()
        signs = np.sign(M[:, i, j])[M[:, i, j] != 0]
        assert found["sign_changes"][i, j] == (signs[1:] != signs[:-1]).sum()
    assert found["histogram"].dtype == np.int64 and found["last"].shape == (3, 3)
    assert summary.work > 0
    energy, last = session.summarize(1000, quantities={"energy": "drift"}, start=1000)["energy"], session.diagnose(1000, invariants="energy")
    assert energy["drift"] == last.invariants[0].drift and energy["drift"].shape == ()


def test_events_have_directions_limits_and_an_end(session):
    both = session.events(2000, events=FLIP, fields="M")
    assert (abs(both["M"][:, 0, 2]) < 1e-13).all() and ((0 < both.fraction) & (both.fraction <= 1)).all() and both.member is None
    assert (both.step * 0.05 <= both.time).all() and (both.time <= (both.step + 1) * 0.05).all() and both.run_status.outcome == "REACHED"
    up, down = (session.events(2000, events={**FLIP, "direction": way}) for way in ("rising", "falling"))
    assert sorted([*up.time, *down.time]) == list(both.time) and abs(up.count - down.count) <= 1
    two = session.events(2000, events=[{**FLIP, "limit": 3, "terminal": True}, {**FLIP, "level": 0.1}])
    assert (two.event == 0).sum() == 3 and two.time.max() == both.time[2]
    assert [time for part in session.stream_events(2000, events=FLIP) for time in part.time] == list(both.time)


def test_a_time_that_the_server_refuses_has_its_index_in_the_caller_s_list(client):
    """1024 states of 64 x 64 frames between two steps are allowed; the times are in descending order."""
    M = np.zeros((64, 64))
    M[0, 1], M[1, 0] = 1, -1
    scene = {"system": "rigid_body", "method": {"name": "rk4"}, "step": 1.0, "inertia": np.arange(1.0, 65),
             "initial": {"Q": np.eye(64), "M": M}}
    times = [2 - 1e-4 * k for k in range(1, 1100)] + [0.5, 1.0]
    k = 1098 - 1024
    with client.create(scene) as session, pytest.raises(stiefel.InvalidArgument) as caught:
        session.trajectory(times=times)
    assert caught.value.violations[0].field == f"times[{k}]"
    assert str(caught.value).startswith(f"times[{k}]: {times[k]!r}: the states between two steps")


def test_states_that_had_arrived_are_in_partial(session):
    times = np.linspace(5e6, 0, 20_000)
    with pytest.raises(stiefel.DeadlineExceeded) as caught:
        session.trajectory(times=times, timeout=1, fields="M")
    partial = caught.value.partial
    assert 0 < partial.samples < 20_000 and partial.outcome == "CANCELLED" and "samples had arrived" in str(caught.value)
    assert list(partial.time) == list(times[-partial.samples:]), "in the order given"
    assert (partial["M"][-1] == session.step(0, fields="M")["M"]).all()


def test_results_of_an_ensemble_have_an_axis_of_members(client):
    """One that stops does not stop the others. Each is what it is alone in the tests of the engine."""
    scene = ensemble(12, step=0.1)
    scene["body"]["angular_velocity"][3 * 5:3 * 5 + 3] = [40.0, 30.0, 20.0]
    with client.create(scene) as session:
        summary = session.summarize(100, quantities={"M": ["last", "max"], "energy": {"statistics": "max", "over_members": True}})
        events = session.events(100, events=FLIP)
    assert summary["M"]["last"].shape == (12, 3, 3) and np.isfinite(summary["M"]["last"]).all() and summary["energy"]["max"].shape == ()
    assert summary.outcome is stiefel.Outcome.LEFT_DOMAIN and summary.outcomes[5] == "LEFT_DOMAIN" and summary.run_status.member == 5
    assert (np.delete(summary.outcomes, 5) == "REACHED").all() and (np.delete(summary.last_step, 5) == 100).all()
    assert summary.last_step[5] == 0 and set(events.member) <= set(range(12)) - {5} and len(set(events.member)) > 3


def test_steps_of_an_ensemble_go_on_after_a_summary(client):
    """A summary takes over what a simulation of the session has of the members, and leaves the simulation where it is."""
    with client.create(ensemble(12)) as session:
        session.step(5003)
        first = session.summarize(10, quantities={"M": "last"})
        assert session.step(5004).computed_steps == 1
        again = session.summarize(10, quantities={"M": "last"})
    assert (first["M"]["last"] == again["M"]["last"]).all()


def test_events_of_a_broken_call_come_once(session, monkeypatch, without_pauses):
    many = [{**FLIP, "level": level} for level in np.linspace(-0.2, 0.2, 40)]
    whole = session.events(20_000, events=many, fields=["Q", "M", "Omega"])
    breaks = Breaks(session._connection.stub.Summarize, [3, 2, 6])
    monkeypatch.setattr(session._connection.stub, "Summarize", breaks)
    again = session.events(20_000, events=many, fields=["Q", "M", "Omega"])
    assert len(breaks.requests) == 4 and again.count > 1000
    assert list(again.time) == list(whole.time) and (again["Q"] == whole["Q"]).all()
