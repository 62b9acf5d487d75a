"""What comes back has fields by name, and is compared by value."""
import copy
import pickle
import re

import numpy as np
import pytest

import stiefel

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


def test_a_trajectory_knows_where_it_comes_from(client, session):
    run = session.trajectory(to=5, every=2)
    for one in (run, run[1:], copy.deepcopy(run), pickle.loads(pickle.dumps(run)), session.trajectory(times=[0.015])):
        assert one.scene == session.scene and one.build == client.describe().numerics_id and one.epoch is None
        assert one.units == {"time": "s", "quaternion": "1", "angular_velocity": "rad/s"}
    with client.create({"system": "rigid_body", "step": 1, "inertia": [1, 2, 3], "initial": {"M": np.zeros((3, 3))}}) as other:
        assert other.trajectory(to=1).units == {"time": "s"}
    with pytest.raises(ValueError, match="does not know its scene"):
        stiefel.Trajectory(run.step, run.time, run.fields, run.run_status).scene


def test_equal_are_those_with_the_same_numbers(answer, session):
    first, second = answer(), answer()
    assert first == second and not first != second and first == first
    assert copy.deepcopy(first) == first == pickle.loads(pickle.dumps(first))
    changed = copy.deepcopy(first)
    changed.fields["M"] = changed["M"] + 1e-16
    assert changed != first
    assert first != dict(first.fields) and first != session.step(39, fields=BLOCKS) and first != session.trajectory(39, fields=BLOCKS)
    with pytest.raises(TypeError, match="unhashable"):
        hash(first)


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
                           (stiefel.Client(channel=client._channel), "give the client an address")):
            with pytest.raises(TypeError, match=f"cannot be pickled.*{why}"):
                pickle.dumps(thing)


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


@pytest.mark.parametrize("kind", [stiefel.InvalidArgument, stiefel.DeadlineExceeded, stiefel.Closed, stiefel.StiefelError])
def test_an_error_can_be_sent_to_another_process(kind):
    error = kind("told", (stiefel.Violation("initial.Q", "1: must be 2"),), "BECAUSE", {"a": "b"})
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind and str(again) == str(error) == "told\n  initial.Q: 1: must be 2"
    assert (again.violations, again.reason, again.metadata) == (error.violations, "BECAUSE", {"a": "b"})
    assert isinstance(again, {stiefel.DeadlineExceeded: TimeoutError, stiefel.InvalidArgument: ValueError}.get(kind, Exception))


FLIP = {"field": "angular_velocity", "coefficients": [1, 0, 0], "level": 0.05}


@pytest.mark.parametrize("asked, path", [
    (["energy"], "quantities"), ({"energy": 3}, "quantities.energy"), ({3: "last"}, "quantities.3"), ({"energy": [3]}, "quantities.energy"),
    ({"energy": {"quantiles": ["a"]}}, "quantities.energy.quantiles"), ({"energy": {"edges": [[1], [2, 3]]}}, "quantities.energy.edges"),
    ({"energy": {"statistics": "mean", "over_members": "no"}}, "quantities.energy.over_members"),
])
def test_a_malformed_summary_is_named(session, asked, path):
    with pytest.raises(stiefel.InvalidArgument, match="must be") as caught:
        session.summarize(10, quantities=asked)
    assert caught.value.violations[0].field == path


@pytest.mark.parametrize("change, path", [
    ({"limit": -1}, "events[0].limit"), ({"level": "x"}, "events[0].level"), ({"field": 3}, "events[0].field"), ({"direction": 1}, "events[0].direction"),
    ({"coefficients": ["a", 1, 0]}, "events[0].coefficients"), ({"terminal": "yes"}, "events[0].terminal"),
    ({"plus": [1, 0, 0]}, "events[0].plus"), ({"plus": {3: [1, 0, 0]}}, "events[0].plus"),
    ({"plus": {"Q": ["a"]}}, "events[0].plus.Q"), ({"plus": {"Q": [1]}}, "events[0].plus[0].coefficients"),
])
def test_a_malformed_event_is_named(session, change, path):
    with pytest.raises(stiefel.InvalidArgument, match="must be") as caught:
        session.events(10, events={**FLIP, **change})
    assert caught.value.violations[0].field == path
    with pytest.raises(stiefel.InvalidArgument, match=r"^events\[0\].levl: unknown field; did you mean level[?] The fields are field, coeff"):
        session.events(10, events={**FLIP, "levl": 1})
    for wrong, place in ((3, "events"), ("FLIP", "events"), ([3], "events[0]")):
        with pytest.raises(stiefel.InvalidArgument, match="must be") as caught:
            session.events(10, events=wrong)
        assert caught.value.violations[0].field == place
