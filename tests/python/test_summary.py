"""Statistics, events and states at any times, against the samples that they are made of."""
import grpc
import numpy as np
import pytest

import stiefel
from fake import Broken
from stiefel import v1 as pb

I, M_1, M_3 = (1.0, 2.0, 3.0), 0.5, 1.5
#: Circles the third axis: m_2 is 0 at the multiples of 2K/p.
TOP = {"system": "rigid_body", "method": {"name": "preprocessed_variational", "order": 10}, "step": 0.05,
       "body": {"moments": I, "angular_velocity": [M_1 / I[0], 0, M_3 / I[2]]}}
FLIP = {"field": "angular_velocity", "coefficients": [0, 1, 0]}
STATISTICS = ["last", "min", "max", "mean", "rms", "sign_changes", "drift"]


def half_period():
    p, k2 = M_3 / I[2], 3 * M_1**2 / M_3**2
    a, b = np.longdouble(1), np.sqrt(np.longdouble(1 - k2))
    for _ in range(10):
        a, b = (a + b) / 2, np.sqrt(a * b)
    return float(np.arccos(np.longdouble(-1)) / a / p)


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
    summary = session.summarize(1000, {"M": [*STATISTICS, {"quantiles": fractions, "edges": edges}]}, start=3, every=7)
    run = session.trajectory(1000, start=3, every=7, fields="M")
    M, found = run["M"], summary["M"]
    assert summary.samples == run.samples and summary.last_step == 1000 and summary.ended_by == -1
    assert summary.outcome == summary.outcomes == stiefel.Outcome.REACHED
    assert (found["last"] == M[-1]).all() and (found["min"] == M.min(0)).all() and (found["max"] == M.max(0)).all()
    assert (found["drift"] == abs(M - session.step(0, "M")["M"]).max(0)).all()
    np.testing.assert_allclose(found["mean"], M.astype(np.longdouble).mean(0).astype(float), rtol=1e-15, atol=1e-17)
    np.testing.assert_allclose(found["rms"], np.sqrt((M.astype(np.longdouble)**2).mean(0)).astype(float), rtol=1e-15)
    assert (found["quantiles"] == np.moveaxis(np.quantile(M, fractions, axis=0), 0, -1)).all()
    for i, j in np.ndindex(3, 3):
        assert (found["histogram"][i, j] == np.histogram(M[:, i, j], edges)[0]).all()
        signs = np.sign(M[:, i, j])[M[:, i, j] != 0]
        assert found["sign_changes"][i, j] == (signs[1:] != signs[:-1]).sum()
    assert found["histogram"].dtype == np.int64 and found["last"].shape == (3, 3)


def test_the_drift_is_diagnose_s(session):
    summary = session.summarize(300, {"energy": "drift", "spatial_momentum": ["drift", "last"]}, every=100)
    diagnoses = [session.diagnose(step).invariants for step in (0, 100, 200, 300)]
    largest = {i.name: max(d[k].drift for d in diagnoses) for k, i in enumerate(diagnoses[0])}
    assert summary["energy"]["drift"] == largest["energy"] and summary["energy"]["drift"].shape == ()
    assert list(summary["spatial_momentum"]["drift"]) == [
        value for name, value in largest.items() if name.startswith("spatial_momentum")]
    assert summary.price.bound == "expected" and summary.price.work > 0


def test_events_are_where_the_closed_form_has_them(session):
    half = half_period()
    flips = session.events(int(50.5 * half / 0.05), FLIP, fields="M")
    assert flips.count == 50 and flips.member is None and flips.run_status.outcome == "REACHED"
    np.testing.assert_allclose(flips.time, half * np.arange(1, 51), rtol=1e-12)
    assert (abs(flips["M"][:, 0, 2]) < 1e-13).all()
    assert ((0 < flips.fraction) & (flips.fraction <= 1)).all()
    assert (flips.step * 0.05 <= flips.time).all() and (flips.time <= (flips.step + 1) * 0.05).all()


def test_events_have_directions_limits_and_an_end(session):
    both = session.events(2000, FLIP)
    up, down = (session.events(2000, {**FLIP, "direction": way}) for way in ("rising", "falling"))
    assert sorted([*up.time, *down.time]) == list(both.time) and abs(up.count - down.count) <= 1
    assert list(session.events(2000, {**FLIP, "limit": 3}).time) == list(both.time[:3])
    two = session.events(2000, [{**FLIP, "limit": 3, "terminal": True}, {**FLIP, "level": 0.1}])
    assert (two.event == 0).sum() == 3 and two.time.max() == both.time[2]
    parts = list(session.stream_events(2000, FLIP))
    assert [time for part in parts for time in part.time] == list(both.time)


def test_an_event_of_a_discrete_system_is_an_interval(client):
    scene = {"system": "moser_veselov", "inertia": [2.5, 1.5, 0.5], "step": 0.1,
             "initial": {"Q": np.eye(3), "M": [[0, -0.3, 2], [0.3, 0, -0.2], [-2, 0.2, 0]]}}
    with client.create(scene) as session:
        events = session.events(300, {"field": "M", "coefficients": [0, 0, 1, 0, 0, 0, 0, 0, 0]})
        run = session.trajectory(300)
        expected = np.flatnonzero(np.diff(np.sign(run["M"][:, 0, 2])))
        assert events.count and list(events.step) == list(expected) and (events.fraction == 1).all()
        assert (events["M"] == run["M"][events.step + 1]).all()
        for times in ([0.3, 0, 29.9], [0.5, -0.2]):
            there = session.trajectory(times=times)
            assert list(there.step) == [round(10 * time) for time in times]
            assert all((there["M"][i] == run["M"][k]).all() for i, k in enumerate(there.step) if k >= 0)
        with pytest.raises(stiefel.InvalidArgument, match=r"times\[1\]: 0.15: must be a whole number of steps of 0.1: moser_veselov is a discrete system"):
            session.trajectory(times=[0.2, 0.15])


def test_states_at_any_times(client, session):
    times = [3.0, 0.0, 0.123, 17.01, 17.02, 3.0]
    run = session.trajectory(times=times, fields=["Q", "M"])
    assert list(run.time) == times and run["Q"].shape == (6, 3, 3)
    assert list(run.step) == [60, 0, 2, 340, 340, 60]
    assert (run["Q"][0] == session.step(60, "Q")["Q"]).all() and (run["Q"][1] == session.step(0, "Q")["Q"]).all()
    exact = {**TOP, "method": {"name": "exact"}}
    with client.create(exact) as closed:
        truth = closed.trajectory(times=times, fields=["Q", "M"])
    for name in ("Q", "M"):
        np.testing.assert_allclose(run[name], truth[name], atol=1e-12)
    assert (session.trajectory(100, fields="Q")["Q"] == session.trajectory(100, fields="Q")["Q"]).all()


@pytest.mark.parametrize("step", [0.1, 0.05, 0.3, -0.01])
def test_decimal_multiples_of_the_step_are_steps(client, step):
    """1.7 is step 17 of 0.1, although 17 * 0.1 is 1.7000000000000002."""
    with client.create({**TOP, "step": step}) as session:
        whole = [round(k * step, 10) for k in range(400)]
        assert list(session.trajectory(times=whole).step) == list(range(400))
        for k in range(1, 400, 3):
            assert list(session.trajectory(times=[whole[k]]).step) == [k]


def test_times_next_to_a_state_have_its_numbers(session):
    """1e-310 and less is a denormal number; 0.05 (1 + 2^-52) is one ulp after step 1."""
    run = session.trajectory(times=[0.0, 5e-324, 1e-310, 1e-200, 1e-100, 1e-30, 0.05 * (1 + 2**-52), 0.05 * (1 - 2**-53)],
                             fields=["Q", "M"])
    assert run.outcome == stiefel.Outcome.REACHED
    for name in ("Q", "M"):
        np.testing.assert_allclose(run[name][1:6], np.broadcast_to(run[name][0], run[name][1:6].shape), rtol=0, atol=1e-15)
        after = session.step(1, fields=name)[name]
        np.testing.assert_allclose(run[name][6:], np.broadcast_to(after, run[name][6:].shape), rtol=0, atol=1e-15)


@pytest.mark.parametrize("arguments, field", [
    (dict(times=[0.1, float("nan")]), "times[1]"), (dict(times=[0.1, 1e300]), "times[1]"),
    (dict(times=[]), "times"), (dict(times=["now"]), "times"), (dict(times=[1.0], to=3), "to"),
    (dict(times=[1.0], start=2), "start"), (dict(times=[1.0], every=7), "every"), (dict(), "to"),
])
def test_wrong_times_are_named_as_given(session, arguments, field):
    with pytest.raises(stiefel.InvalidArgument) as caught:
        session.trajectory(**arguments)
    assert caught.value.violations[0].field == field and str(caught.value).startswith(f"{field}: ")


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


def test_times_may_be_on_both_sides_of_0(client):
    with client.create({**TOP, "step": -0.05}) as session:
        assert list(session.trajectory(times=[-0.31, 0.0, -0.01]).step) == [6, 0, 0]
        both = session.trajectory(times=[0.3, -0.31, 0.11], fields=["Q", "M"])
        before = session.trajectory(times=[-0.31], fields=["Q", "M"])
    with client.create(TOP) as session:
        after = session.trajectory(times=[0.3, 0.11], fields=["Q", "M"])
    assert list(both.time) == [0.3, -0.31, 0.11] and list(both.step) == [-6, 6, -2]
    for name in ("Q", "M"):
        assert (both[name][[0, 2]] == after[name]).all() and (both[name][1] == before[name][0]).all()


def test_states_that_had_arrived_are_in_partial(session):
    times = np.linspace(5e6, 0, 20_000)
    with pytest.raises(stiefel.DeadlineExceeded) as caught:
        session.trajectory(times=times, timeout=1, fields="M")
    partial = caught.value.partial
    assert 0 < partial.samples < 20_000 and partial.outcome == "CANCELLED" and "samples had arrived" in str(caught.value)
    assert list(partial.time) == list(times[-partial.samples:]), "in the order given"
    assert (partial["M"][-1] == session.step(0, "M")["M"]).all()


def test_members_are_as_alone(client):
    scene = ensemble(20)
    asked = {"M": [*STATISTICS, {"quantiles": [0.3]}], "energy": ["drift", "last"]}
    with client.create(scene) as session:
        summary = session.summarize(500, asked, every=3)
        events = session.events(500, FLIP)
        over = session.summarize(500, {"M": {"statistics": ["min", "max", "sign_changes"], "over_members": True}}, every=3)
        run = session.trajectory(500, every=3, fields="M")
        states = session.trajectory(times=[1.01, 2.02], fields="M")
    assert summary["M"]["last"].shape == (20, 3, 3) and list(summary.outcomes) == ["REACHED"] * 20
    assert (over["M"]["min"] == run["M"].min((0, 1))).all() and (over["M"]["max"] == run["M"].max((0, 1))).all()
    assert (over["M"]["sign_changes"] == summary["M"]["sign_changes"].sum(0)).all()
    for member in (0, 7, 19):
        spin = scene["body"]["angular_velocity"][3 * member:3 * member + 3]
        with client.create({**TOP, "body": {**TOP["body"], "angular_velocity": spin}}) as alone:
            one, flips = alone.summarize(500, asked, every=3), alone.events(500, FLIP)
            assert (alone.trajectory(times=[1.01, 2.02], fields="M")["M"] == states["M"][:, member]).all()
        for name, statistics in one.items():
            for statistic, values in statistics.items():
                assert summary[name][statistic][member].tobytes() == values.tobytes(), (name, statistic)
        assert list(events.time[events.member == member]) == list(flips.time)


def test_members_that_stop_do_not_stop_the_others(client):
    scene = ensemble(12, step=0.1)
    scene["body"]["angular_velocity"][3 * 5:3 * 5 + 3] = [40.0, 30.0, 20.0]
    with client.create(scene) as session:
        summary = session.summarize(100, {"M": ["last", "max"]})
    assert summary.outcomes[5] == "LEFT_DOMAIN" and summary.run_status.member == 5
    assert summary.outcome is stiefel.Outcome.LEFT_DOMAIN
    assert (np.delete(summary.outcomes, 5) == "REACHED").all() and (np.delete(summary.last_step, 5) == 100).all()
    assert summary.last_step[5] == 0 and np.isfinite(summary["M"]["last"]).all()


def every_message(session, **request):
    return list(session._connection.stub.Summarize(pb.SummarizeRequest(session_id=session.id, **request)))


def arrays(messages):
    return {field.name: field.value.data for message in messages for field in message.statistics}


def test_a_checkpoint_goes_on_with_the_same_bytes(session):
    request = dict(to=1000, every=3, quantities=[
        pb.Quantity(name="M", statistics=range(1, 8), quantiles=[0.1, 0.9]), pb.Quantity(name="energy", statistics=[7, 4])],
        events=[pb.Event(field="angular_velocity", coefficients=[0, 1, 0])])
    whole = every_message(session, checkpoint_every=130, **request)
    checkpoints = [m.checkpoint for m in whole if m.HasField("checkpoint")]
    assert [c.step for c in checkpoints] == list(range(130, 1000, 130))
    times = [time for m in whole for time in m.events.times]
    for checkpoint in checkpoints:
        rest = every_message(session, checkpoint=checkpoint.data, **request)
        assert arrays(rest) == arrays(whole)
        late = [time for m in rest for time in m.events.times]
        assert late == times[len(times) - len(late):] and rest[-1].computed_steps == whole[-1].computed_steps
    other = {**request, "every": 5}
    with pytest.raises(grpc.RpcError, match="must come from a Summarize of the same request"):
        every_message(session, checkpoint=checkpoints[0].data, **other)
    for damaged in (checkpoints[0].data[:-1], b"x", checkpoints[0].data[:100] + bytes([checkpoints[0].data[100] ^ 1]) + checkpoints[0].data[101:]):
        with pytest.raises(grpc.RpcError, match="damaged"):
            every_message(session, checkpoint=damaged, **request)


class Breaks:
    """Summarize, broken after so many messages, once for each number."""

    def __init__(self, call, after):
        self.call, self.after, self.requests = call, list(after), []

    def __call__(self, request, timeout=None, metadata=None):
        self.requests.append(pb.SummarizeRequest.FromString(request.SerializeToString()))
        return self

    def __iter__(self):
        stream, left = self.call(self.requests[-1]), self.after.pop(0) if self.after else None
        for message in stream:
            if left == 0:
                stream.cancel()
                raise Broken()
            left = None if left is None else left - 1
            yield message

    def initial_metadata(self):
        return ()

    def cancel(self):
        pass


@pytest.mark.parametrize("checkpoint_every", [0, 100])
def test_a_broken_call_goes_on(session, monkeypatch, without_pauses, checkpoint_every):
    asked = {"M": [*STATISTICS, {"quantiles": [0.5]}]}
    whole = session.summarize(1000, asked)
    breaks = Breaks(session._connection.stub.Summarize, [2, 4, 1])
    monkeypatch.setattr(session._connection.stub, "Summarize", breaks)
    again = session.summarize(1000, asked, checkpoint_every=checkpoint_every)
    if checkpoint_every:
        assert len(breaks.requests) == 4
        assert breaks.requests[1].checkpoint and breaks.requests[1].checkpoint != breaks.requests[2].checkpoint
        assert 1000 <= again.computed_steps <= 1000 + 3 * 100
    for statistic, values in whole["M"].items():
        assert again["M"][statistic].tobytes() == values.tobytes()


def test_a_call_that_ends_at_its_price_goes_on(client):
    """On a flat ellipsoid `adaptive` takes more substeps than predicted, so the first call ends at its price."""
    scene = {"system": "ellipsoid", "inertia": [1, 0.8, 1e-6], "step": 0.1, "method": {"name": "adaptive", "tolerance": 1e-12},
             "initial": {"q": [0, 0, 1], "qdot": [1, 0.1, 0]}}
    with client.create(scene) as session:
        summary = session.summarize(400, {"q": STATISTICS}, every=2)
        assert summary.samples == 201 and summary.outcome == "REACHED" and summary.computed_steps == 400
        q = session.trajectory(400, every=2, fields="q")["q"]
    assert (summary["q"]["last"] == q[-1]).all() and (summary["q"]["min"] == q.min(0)).all()
    np.testing.assert_allclose(summary["q"]["mean"], q.astype(np.longdouble).mean(0).astype(float), rtol=1e-14, atol=1e-17)


def test_events_of_a_broken_call_come_once(session, monkeypatch, without_pauses):
    many = [{**FLIP, "level": level} for level in np.linspace(-0.2, 0.2, 40)]
    whole = session.events(20_000, many, fields=["Q", "M", "Omega"])
    breaks = Breaks(session._connection.stub.Summarize, [3, 2, 6])
    monkeypatch.setattr(session._connection.stub, "Summarize", breaks)
    again = session.events(20_000, many, fields=["Q", "M", "Omega"])
    assert len(breaks.requests) == 4 and again.count > 1000
    assert list(again.time) == list(whole.time) and (again["Q"] == whole["Q"]).all()


@pytest.mark.parametrize("change, field", [
    (dict(quantities=[pb.Quantity(name="enrgy", statistics=[1])]), "quantities[0].name"),
    (dict(quantities=[pb.Quantity(name="energy", statistics=[99])]), "quantities[0].statistics"),
    (dict(quantities=[pb.Quantity(name="energy")]), "quantities[0].statistics"),
    (dict(quantities=[pb.Quantity(name="energy", statistics=[1])] * 65), "quantities"),
    (dict(quantities=[pb.Quantity(name="M", quantiles=[0.5])], to=2**20), "quantities"),
    (dict(quantities=[pb.Quantity(name="M", edges=[2, 1])]), "quantities[0].edges"),
    (dict(events=[pb.Event(field="M", coefficients=[1])]), "events[0].coefficients"),
    (dict(events=[pb.Event(field="M", coefficients=[float("nan")] * 9)]), "events[0]"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, direction=7)]), "events[0].direction"),
    (dict(events=[pb.Event(field="M", coefficients=[1] * 9, plus=[pb.LinearTerm(field="M", coefficients=[0] * 9)] * 65)]), "events[0].plus"),
    (dict(times=[0.5, 0.2]), "times[1]"),
    (dict(times=[float("inf")]), "times[0]"),
    (dict(times=[6.0]), "times[0]"),
    (dict(fields=["nothing"]), "fields[0]"),
    (dict(to=-1), "to"),
    (dict(every=-1), "every"),
    (dict(checkpoint_every=-1), "checkpoint_every"),
])
def test_a_wrong_request_names_its_field(session, change, field):
    with pytest.raises(stiefel.InvalidArgument) as caught:
        try:
            every_message(session, **{"to": 100, **change})
        except grpc.RpcError as failure:
            raise session._connection.error(failure) from None
    assert caught.value.violations[0].field == field
    assert session.summarize(10, {"energy": "drift"}).outcome == "REACHED"
