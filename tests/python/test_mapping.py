"""What comes back has fields by name, comes with a short repr, and is compared by value."""
import copy
import dataclasses
import os
import pickle
import re
import subprocess
import sys
from collections.abc import Mapping

import numpy as np
import pytest

import stiefel
from stiefel import v1 as pb

SCENE = {"system": "rigid_body", "method": {"name": "variational"}, "step": 0.01,
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}

BLOCKS = ["Q", "M"]


@pytest.fixture(scope="module")
def session(client):
    with client.create(SCENE) as session:
        yield session


@pytest.fixture(params=["state", "trajectory", "batch"])
def answer(session, request):
    return {"state": lambda: session.step(to=40, fields=BLOCKS), "trajectory": lambda: session.trajectory(to=40, fields=BLOCKS),
            "batch": lambda: next(session.stream(to=40, fields=BLOCKS))}[request.param]


def test_fields_have_names(answer):
    fields = answer()
    assert list(fields.fields) == ["Q", "M"] == fields._ipython_key_completions_()
    assert "Q" in fields and "quaternion" not in fields and 0 not in fields and fields.fields["Q"] is fields["Q"]
    for wrong, told in (("Omega", r"no field 'Omega'; the fields are Q, M; `fields=\['Omega'\]` asks for it"), (1.5, "1.5")):
        with pytest.raises(KeyError, match=told):
            fields[wrong]


def test_a_trajectory_is_a_sequence_of_states(session):
    for run in (session.trajectory(to=40, every=3), next(session.stream(to=40, every=3))):
        assert len(run) == run.samples == 15 and [state.step for state in run] == list(run.step)
        assert all(isinstance(state, stiefel.State) and state.outcome == "REACHED" for state in run)
        assert run[4] == session.step(to=12) == run[-11] == run[np.int64(4)] and run[-1] == session.step(to=40)
        part = run[3:9:2]
        assert type(part) is type(run) and list(part.step) == [9, 15, 21] == list(part.time / 0.01) and part[1] == run[5]
        assert len(run[:0]) == 0 and list(run[::-1].step) == list(run.step)[::-1]
        assert part["quaternion"].base is not None and (part["quaternion"] == run["quaternion"][3:9:2]).all()
        for wrong in (15, -16):
            with pytest.raises(IndexError, match=f"{wrong}: there are 15 samples"):
                run[wrong]
        for wrong in (True, [1, 2], run.time > 0.2):
            with pytest.raises(KeyError, match="no field"):
                run[wrong]


def test_a_part_of_a_run_that_stopped_ended_well(client):
    with client.create({**SCENE, "step": 1.5, "method": {"name": "rk4"}}) as session:
        run = session.trajectory(to=1000)
    assert run.outcome == "NOT_FINITE" and len(run) > 2 and run[1:].outcome == run[-1].outcome == "NOT_FINITE"
    assert run[:-1].outcome == run[0].outcome == "REACHED" and [s.outcome for s in run][-2:] == ["REACHED", "NOT_FINITE"]


def test_a_trajectory_knows_where_it_comes_from(client, session):
    run = session.trajectory(to=5, every=2)
    for one in (run, run[1:], copy.deepcopy(run), pickle.loads(pickle.dumps(run)), session.trajectory(times=[0.015])):
        assert one.scene == session.scene and one.build == client.describe().numerics_id and one.epoch is None
        assert one.units == {"time": "s", "quaternion": "1", "angular_velocity": "rad/s"}
    with client.create({"system": "rigid_body", "step": 1, "inertia": [1, 2, 3], "initial": {"M": np.zeros((3, 3))}}) as other:
        assert other.trajectory(to=1).units == {"time": "s"}
    with pytest.raises(ValueError, match="does not know its scene"):
        stiefel.Trajectory(run.step, run.time, run.fields, run.run_status).scene


def test_a_state_is_a_mapping_of_its_fields(session):
    fields = session.step(to=40, fields=BLOCKS)
    assert isinstance(fields, Mapping) and list(fields) == ["Q", "M"] == list(fields.keys()) and len(fields) == 2
    assert [name for name, _ in fields.items()] == ["Q", "M"]
    assert all(one is other for one, other in zip(fields.values(), fields.fields.values()))
    assert fields.get("Q") is fields["Q"] and fields.get("Omega") is None and fields.get("Omega", 3) == 3
    assert dict(fields).keys() == {"Q", "M"} and (np.asarray({**fields}["M"]) == fields["M"]).all()


def test_equal_are_those_with_the_same_numbers(answer, session):
    first, second = answer(), answer()
    assert first == second and not first != second and first == first
    assert copy.deepcopy(first) == first == pickle.loads(pickle.dumps(first))
    changed = copy.deepcopy(first)
    changed.fields["M"] = changed["M"] + 1e-16
    assert changed != first
    assert first != dict(first.fields) and first != session.step(39, BLOCKS) and first != session.trajectory(39, fields=BLOCKS)
    with pytest.raises(TypeError, match="unhashable"):
        hash(first)


def test_what_it_cost_is_no_part_of_a_state(client):
    with client.create(SCENE) as session:
        first, second = session.step(to=50, checkpoint=True), session.step(to=50)
    assert (first.computed_steps, second.computed_steps) == (50, 0) and first == second


def test_not_a_number_is_what_it_is(client):
    def state(fields):
        return stiefel.State(1, 0.5, fields, stiefel.RunStatus(stiefel.Outcome.REACHED), 0, b"")

    first = state({"x": np.array([[np.nan]])})
    assert first == state({"x": np.array([[np.nan]])})
    assert all(first != state(other) for other in ({"x": np.array([[0.0]])}, {"y": np.array([[np.nan]])}, {"x": np.full((1, 2), np.nan)}))
    ways = [client.geodesic([1, 2, 3], [[1, 0, 0]], end, samples=3) for end in ([[0, 1, 0]], [[0, 1, 0]], [[0, 0, 1]])]
    assert ways[0] == ways[1] != ways[2]


def test_a_repr_is_a_line(session, client):
    run, state = session.trajectory(to=40, every=10, fields=BLOCKS), session.step(to=40)
    assert repr(run) == "<stiefel.Trajectory REACHED of 5 samples, steps 0 to 40: Q (5, 3, 3), M (5, 3, 3)>"
    assert repr(state) == "<stiefel.State REACHED at step 40, time 0.4: quaternion (4,), angular_velocity (3,)>"
    assert repr(next(session.stream(to=0, fields=BLOCKS))) == "<stiefel.Batch of 1 sample, steps 0 to 0: Q (1, 3, 3), M (1, 3, 3)>"
    assert repr(session) == f"<stiefel.Session {session.id}: rigid_body variational, step 0.01>"
    assert repr(client) == f"<stiefel.Client of {client.address}>"


def every_answer(client, scene, frames):
    """One result of every type for a scene."""
    without = {name: value for name, value in scene.items() if name != "method"}
    with client.create(scene) as session, client.create({**without, "tolerance": 1e-6, "horizon": 1.0}) as chosen:
        state, diagnosis = session.step(to=3), session.diagnose(to=3, estimate_error=True)
        yield from (client, session, state, state.run_status, state.price, session.trajectory(to=3), next(session.stream(to=3)))
        yield from (diagnosis, diagnosis.estimated_error, diagnosis.invariants[0], diagnosis.domain, chosen.choice)
        yield session.summarize(3, {"energy": ["drift", "mean"], "M": "last"})
        yield from (client.describe(), session.error_at([0.01]))
        yield session.events(3, {"field": "M", "coefficients": np.ones(state["M"].size if "M" in state else 9)})
        yield from (client.convert(scene, "symmetric_rigid_body"), client.convert(scene, "velocity"))
        tradeoff = client.tradeoff(scene, horizon=0.1, budget=2e9, repeats=1)
        yield from (tradeoff, tradeoff.points[0], client.geodesic(np.ones(frames[0].shape[1]), *frames, samples=30))


def test_no_answer_prints_more_than_three_lines(client):
    M = np.triu(np.ones((20, 20)), 1)
    large = {"system": "rigid_body", "step": 0.01, "method": {"name": "rk4"}, "inertia": np.arange(1.0, 21),
             "initial": {"Q": np.eye(20), "M": M - M.T}}
    frames = np.eye(3, 20), np.eye(3, 20)[[1, 2, 0]]
    for scene in (SCENE, large):
        for answer in every_answer(client, scene, frames):
            if type(answer).__module__.startswith("stiefel"):
                for text in (repr(answer), str(answer)):
                    assert len(text.splitlines()) <= 3 and len(text) < 1000, type(answer)
                shown = answer._repr_html_() if not isinstance(answer, (stiefel.Client, stiefel.Session)) else "<table></table>"
                assert shown.startswith("<table>") and shown.endswith("</table>") and len(shown) < 20_000, type(answer)


def test_a_diagnosis_has_a_table_with_every_invariant(client):
    velocities = [[0.1, 2, 0.1], [30, 1, 0.25]]
    with client.create({**SCENE, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": velocities}}) as session:
        diagnosis = session.diagnose(to=50)
    lines = diagnosis.table().splitlines()
    for invariant, line in zip(diagnosis.invariants, lines[1:]):
        assert line.startswith(f"  {invariant.name} of member {invariant.member} ") and f"drift {invariant.drift:.1e}" in line
    assert len(lines) > 6 and lines[0] == "REACHED at step 50, time 0.5"


def test_a_client_is_pickled_by_its_address(client):
    given = dict(timeout=3.0, any_build=True)
    with stiefel.Client(client.address, **given) as first, pickle.loads(pickle.dumps(first)) as again:
        assert again is not first and again.address == client.address and again.describe().systems
        assert {name: getattr(again, name) for name in given} == given
    with copy.copy(client) as other:
        assert other.describe().systems


def test_what_cannot_be_pickled_says_why(client, session):
    with stiefel.Client(client.address, token="secret") as with_token, session.drive() as drive:
        for thing, why in ((session, "send its `id`"), (drive, "an open stream"), (with_token, "STIEFEL_TOKEN"),
                           (stiefel.Client(channel=client.channel), "give the client an address")):
            with pytest.raises(TypeError, match=f"cannot be pickled.*{why}"):
                pickle.dumps(thing)


def test_a_text_is_one_name(session):
    for fields in ("quaternion", ["quaternion"], ("quaternion",), iter(["quaternion"])):
        assert list(session.step(to=3, fields=fields)) == ["quaternion"]
    assert list(session.trajectory(to=3, fields="angular_velocity").fields) == ["angular_velocity"]
    assert list(next(session.stream(to=3, fields="M")).fields) == ["M"]
    with session.drive(fields="M") as drive:
        assert list(drive.step(1)) == ["M"] and list(drive.step(1, fields="Q")) == ["Q"]
    assert [i.name for i in session.diagnose(to=3, invariants="energy").invariants] == ["energy"]
    with pytest.raises(stiefel.InvalidArgument, match="fields: 3: must be a name"):
        session.step(to=3, fields=["Q", 3])


def test_kept_is_a_word(client):
    with client.create({**SCENE, "method": {"name": "splitting"}}) as session:
        diagnosis = session.diagnose(to=100)
        declared = {p.invariant: stiefel.Conservation(p.conservation) for system in client.describe().systems
                    for on in system.methods if (system.name, on.method) == ("rigid_body", "splitting")
                    for p in on.preserves}
    kept = {invariant.name.partition("[")[0]: invariant.conservation for invariant in diagnosis.invariants}
    assert kept.items() <= declared.items()
    assert kept["energy"] is stiefel.Conservation.BOUNDED == "bounded"
    assert kept["casimirs" if "casimirs" in kept else "spatial_momentum"] == stiefel.Conservation.EXACT
    assert f"{kept['energy']}" == str(kept["energy"]) == "bounded"
    assert [stiefel.Conservation(number) for number in pb.Conservation.values()] == [
        "unspecified", "exact", "bounded", "drifts"]
    assert stiefel.Conservation(99) is stiefel.Conservation.UNSPECIFIED


def test_a_diagnosis_is_typed(session):
    diagnosis = session.diagnose(to=100, invariants=["energy"])
    assert diagnosis == session.diagnose(to=100, invariants=["energy"])
    assert diagnosis.outcome is stiefel.Outcome.REACHED and (diagnosis.step, diagnosis.time) == (100, 1.0)
    assert diagnosis.orthogonality < 1e-13 and diagnosis.symplectic_defect is None and diagnosis.forms == ()
    assert diagnosis.domain.h_omega == pytest.approx(0.02, rel=0.1) and diagnosis.invariants[0].member is None
    assert repr(diagnosis.invariants[0]).startswith("Invariant(name='energy', initial=")
    assert "energy" in str(diagnosis) and "exact" in str(diagnosis) and "estimated error" not in str(diagnosis)
    told = str(session.diagnose(to=100, estimate_error=True)).splitlines()[-1]
    assert re.fullmatch(r"  estimated error: attitude \S+, momentum \S+ from .+", told)


@pytest.mark.parametrize("change, told", [
    ({}, "attitude 1.0e-03, momentum 2.0e-04 from the closed form"),
    ({"attitude": None}, "momentum 2.0e-04 from the closed form"),
    ({"attitude": None, "momentum": None}, "below 2.0e-16 from the closed form"),
    ({"attitude": None, "momentum": None, "missing": "it takes too long"}, "none: it takes too long"),
])
def test_an_estimated_error_is_a_line(change, told):
    estimate = stiefel.EstimatedError(1e-3, 2e-4, 1e-3, 1e-16, "the closed form", 1.0, 1.0, "", None)
    assert str(dataclasses.replace(estimate, **change)) == told


@pytest.mark.parametrize("kind", [stiefel.InvalidArgument, stiefel.DeadlineExceeded, stiefel.Closed,
                                  stiefel.NotStarted, stiefel.StiefelError])
def test_an_error_can_be_sent_to_another_process(kind):
    error = kind("told", (stiefel.Violation("initial.Q", "1: must be 2"),), "BECAUSE", {"a": "b"})
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind and str(again) == str(error) == "told\n  initial.Q: 1: must be 2"
    assert (again.violations, again.reason, again.metadata) == (error.violations, "BECAUSE", {"a": "b"})


FLIP = {"field": "angular_velocity", "coefficients": [1, 0, 0], "level": 0.05}


def test_events_are_compared_by_value(session):
    events, again = (session.events(2000, FLIP, fields=["Q", "quaternion"]) for _ in range(2))
    assert list(events.fields) == ["Q", "quaternion"] and len(events) == events.count and "Q" in events
    assert 0 not in events and events["Q"].shape == (events.count, 3, 3) and list(events[1:].time) == list(events.time[1:])
    assert [one.time[0] for one in events] == list(events.time) and (events[:2]["Q"] == events["Q"][:2]).all()
    assert events == again and events != session.events(1000, FLIP, fields=["Q", "quaternion"]) and events.count > 2
    assert events != session.events(2000, FLIP, fields=["Q"])
    assert repr(events) == (f"<stiefel.Events REACHED of {events.count} zeros: Q ({events.count}, 3, 3), "
                            f"quaternion ({events.count}, 4)>")
    with pytest.raises(KeyError, match="no field 'P'; the fields are Q, quaternion"):
        events["P"]
    with pytest.raises(TypeError):
        hash(events)


def test_no_events_have_the_fields_too(session, client):
    never = {**FLIP, "level": 1e6}
    none = session.events(50, never)
    assert none.count == 0 and none.member is None and {name: part.shape for name, part in none.fields.items()} == {
        "quaternion": (0, 4), "angular_velocity": (0, 3)} and none.run_status.outcome == "REACHED"
    assert session.events(50, never, fields=iter(["angular_velocity"]))["angular_velocity"].shape == (0, 3)
    some = session.events(2000, FLIP)
    for name in ("event", "step", "fraction", "time"):
        assert getattr(none, name).dtype == getattr(some, name).dtype, name
    assert all(none[name].dtype == some[name].dtype for name in some.fields)
    with client.create({**SCENE, "members": 2}) as ensemble:
        none = ensemble.events(50, never)
        assert none.member.shape == (0,) and none["quaternion"].shape == (0, 4) and none == ensemble.events(50, never)


def test_summaries_are_compared_by_value(session):
    asked = {"Q": "last", "energy": ["drift", "mean"]}
    summary = session.summarize(100, asked)
    assert summary == session.summarize(100, asked) != session.summarize(99, asked)
    assert summary != session.summarize(100, {"Q": "last"}) and list(summary) == ["Q", "energy"] and "Q" in summary
    with pytest.raises(KeyError, match="no quantity 'x'; the quantities are Q, energy"):
        summary["x"]
    assert summary._ipython_key_completions_() == ["Q", "energy"]


@pytest.mark.parametrize("asked, path", [
    (["energy"], "quantities"), (3, "quantities"), ({"energy": 3}, "quantities.energy"), ({3: "last"}, "quantities.3"),
    ({"energy": [3]}, "quantities.energy"), ({"energy": {"statistics": 3}}, "quantities.energy.statistics"), ({"energy": {"name": "M"}}, "quantities.energy.name"),
    ({"energy": {"quantiles": ["a"]}}, "quantities.energy.quantiles"), ({"energy": {"edges": [[1], [2, 3]]}}, "quantities.energy.edges"),
    ({"energy": {"statistics": "mean", "over_members": "no"}}, "quantities.energy.over_members"),
    ({"energy": {"statistics": [["mean"]]}}, "quantities.energy.statistics"),
])
def test_a_malformed_summary_is_named(session, asked, path):
    with pytest.raises(stiefel.InvalidArgument, match="must be") as caught:
        session.summarize(10, asked)
    assert caught.value.violations[0].field == path


@pytest.mark.parametrize("change, path", [
    ({"limit": -1}, "events[0].limit"), ({"limit": 1.5}, "events[0].limit"), ({"level": "x"}, "events[0].level"),
    ({"field": 3}, "events[0].field"), ({"coefficients": ["a", 1, 0]}, "events[0].coefficients"),
    ({"direction": 1}, "events[0].direction"), ({"direction": ["rising"]}, "events[0].direction"), ({"terminal": "yes"}, "events[0].terminal"),
    ({"plus": [1, 0, 0]}, "events[0].plus"), ({"plus": {3: [1, 0, 0]}}, "events[0].plus"),
    ({"plus": {"Q": ["a"]}}, "events[0].plus.Q"), ({"plus": {"Q": [1]}}, "events[0].plus[0].coefficients"),
])
def test_a_malformed_event_is_named(session, change, path):
    with pytest.raises(stiefel.InvalidArgument, match="must be") as caught:
        session.events(10, {**FLIP, **change})
    assert caught.value.violations[0].field == path
    with pytest.raises(stiefel.InvalidArgument, match=r"^events\[0\].levl: unknown field; did you mean level[?] The fields are field, coeff"):
        session.events(10, {**FLIP, "levl": 1})
    for wrong, place in ((3, "events"), ("FLIP", "events"), ([3], "events[0]")):
        with pytest.raises(stiefel.InvalidArgument, match="must be") as caught:
            session.events(10, wrong)
        assert caught.value.violations[0].field == place


def test_an_event_may_have_numbers_of_numpy(session):
    plain, numpy = FLIP, {**FLIP, "level": np.float64(0.05), "limit": np.int64(2), "terminal": np.bool_(True)}
    assert (session.events(2000, numpy).time == session.events(2000, plain).time[:2]).all()


def test_completion_offers_what_is_public(session):
    assert set(stiefel.__all__) < set(dir(stiefel)) and all(hasattr(stiefel, name) for name in dir(stiefel))
    assert session.step(to=1)._ipython_key_completions_() == ["quaternion", "angular_velocity"]


RAY = """
import stiefel
with stiefel.ray.Executor(num_cpus=2) as executor:
    assert executor._max_workers == 4
try:
    stiefel.rey
except AttributeError as error:
    assert str(error) == "module 'stiefel' has no attribute 'rey'"
"""


def test_the_executor_of_ray_needs_no_import_of_its_own(tmp_path):
    """Ray stands in for itself here: a module with the few functions that the constructor calls."""
    (tmp_path / "ray.py").write_text("def is_initialized(): return True\n"
                                     "def remote(**options): return lambda function: function\n"
                                     "def cluster_resources(): return {'CPU': 8}\n")
    path = os.pathsep.join([str(tmp_path), *sys.path])
    done = subprocess.run([sys.executable, "-c", RAY], env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_errors_are_python_s_too():
    assert issubclass(stiefel.DeadlineExceeded, TimeoutError) and issubclass(stiefel.InvalidArgument, ValueError)


def test_a_table_escapes_and_ends(client):
    from stiefel._results import html

    assert html.table("a < b", ("x",), [("<&>",)] * 30).count("&lt;&amp;&gt;") == html.ROWS
    assert "and 10 more" in html.table("", (), [(1,)] * 30) and html.brief("x" * 500).endswith("…")
    assert "quaternion" in client.describe()._repr_html_() and client.describe() == client.describe()
    with client.create({**SCENE, "members": 3}) as session:
        diagnosis = session.diagnose(to=5, estimate_error=True)
    assert "of member" in str(diagnosis) and "of member" in diagnosis._repr_html_()


def test_what_has_several_fields_is_no_array(client):
    """numpy would make an array of objects of it."""
    with client.create(SCENE) as session:
        run = session.trajectory(to=2, fields=["Q", "M"])
        for one in (run, run[0], next(session.stream(to=2, fields=["Q", "M"])), session.step(to=1, fields=["Q", "M"])):
            with pytest.raises(TypeError, match=r"is several arrays, Q \(.*3, 3\), M \(.*3, 3\): take one of them by its name, \['Q'\]"):
                np.asarray(one)
        assert np.asarray(run["Q"]).shape == (3, 3, 3)
