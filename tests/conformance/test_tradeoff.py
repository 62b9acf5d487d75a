"""MeasureTradeoff, and the choice of a method for a tolerance."""
import math

import pytest

import scenes
import stiefel
from stiefel import v1 as pb


def scene(**changes):
    return scenes.rigid_body(**{"step": 0.1, **changes})


SMALL = dict(horizon=2.0, budget=3e8, repeats=2)


@pytest.fixture(scope="module")
def measured(client):
    return client.tradeoff(scene(), **SMALL)


def test_it_says_what_it_measured_against_and_on_what(measured):
    assert measured.machine and len(measured.numerics_id) == 16 and "quadruple" in measured.reference
    assert 0 < measured.reference_error < 1e-16
    assert (measured.horizon, measured.steps, measured.reference_steps, measured.repeats) == (2.0, 20, 20, 2)


def test_a_point_has_its_cost_and_its_times(measured):
    for point in measured.points:
        assert point.outcome == stiefel.Outcome.REACHED
        assert point.work > 0 and point.scalar in ("double", "float") and point.measured_steps >= 1
        assert len(point.cpu_seconds_per_second) == 2 and min(point.cpu_seconds_per_second) > 0
        assert point.steps_per_second > 0 and math.isfinite(point.drift)


def begun(client, scene, **request):
    """The messages as they arrive."""
    return client._stub.MeasureTradeoff(pb.MeasureTradeoffRequest(scene=stiefel.to_message(scene), **request))


def test_points_arrive_one_by_one(client):
    kinds = [part.WhichOneof("part") for part in begun(client, scene(), **SMALL)]
    assert kinds[0] == "setup" and kinds[-1] == "front" and set(kinds[1:-1]) == {"point"}


def test_the_horizon_is_the_scenes_or_a_hundred_steps(client):
    own = next(begun(client, scene(horizon=3.05), budget=1e8)).setup
    assert own.steps == 31
    assert next(begun(client, scene(), budget=1e8)).setup.steps == 100
    assert next(begun(client, scene(step=-0.1), horizon=1.0, budget=1e8)).setup.steps == 10


@pytest.mark.parametrize("change, request_change, fault", [
    ({}, {"horizon": -1.0}, "^horizon: -1"), ({}, {"horizon": float("nan")}, "^horizon"),
    ({}, {"budget": 0.0}, "^budget: 0"), ({}, {"repeats": 0}, "^repeats: 0"), ({}, {"repeats": 101}, "^repeats"),
    ({"system": "moser_veselov"}, {}, "scene.system.*discrete"), ({"inertia": [1, 2]}, {}, "scene.initial"),
    ({"step": 0.0}, {}, "scene.step"),
], ids=lambda value: None if isinstance(value, str) else "".join(value))
def test_what_has_no_meaning_names_the_field(client, change, request_change, fault):
    with pytest.raises(stiefel.InvalidArgument, match=fault):
        client.tradeoff(scene(**change), **request_change)


# The choice of a method for a tolerance


def chosen(**changes):
    return scene(**{"method": None, "tolerance": 1e-8, "horizon": 5.0, **changes})


def test_the_resolved_scene_has_a_method_and_says_why(client):
    with client.create(chosen()) as session:
        resolved, choice = session.scene, session._message.choice
        assert choice.method == session._resolved().method and choice.tolerance == 1e-8 and choice.horizon == 5.0
        assert resolved["method"]["name"] in choice.reason and "1e-08" in choice.reason
        assert resolved["step"] == 0.1 and "tolerance" not in resolved and resolved["horizon"] == 5.0
        state = session.step(50)
    fine = scene(method={"name": "variational", "order": 8, "substeps": 16})
    with client.create(fine) as session:
        assert abs(state["Q"] - session.step(50)["Q"]).max() <= 1e-8


def test_the_resolved_scene_is_created_again_as_it_is(client):
    with client.create(chosen()) as session:
        with client.create(session.scene) as again:
            assert again.scene == session.scene
            assert again.choice is None and session.choice is not None
        with client.create(chosen(), id=session.id) as same:  # the same scene gives the same session
            assert not same.created and same._message.choice == session._message.choice


def test_another_server_of_the_build_chooses_alike(client, other):
    with client.create(chosen(tolerance=1e-5)) as here, other.create(chosen(tolerance=1e-5)) as there:
        assert here.scene == there.scene


def test_a_fork_with_another_method_is_not_what_was_chosen(client):
    with client.create(chosen()) as session:
        with session.fork(3) as moved:
            assert moved.scene["method"] == session.scene["method"] and moved.choice is None
        with session.fork(3, method={"name": "rk4"}) as changed:
            assert changed.scene["method"]["name"] == "rk4" and changed.choice is None
            assert changed.scene["horizon"] == 5.0


@pytest.mark.parametrize("change, fault", [
    ({"horizon": None}, "^scene.horizon: absent"), ({"horizon": 0.0}, "^scene.horizon: 0"), ({"horizon": math.inf}, "^scene.horizon: inf"),
    ({"tolerance": 0.0}, "^scene.tolerance: 0"), ({"tolerance": 3.0}, "^scene.tolerance: 3"), ({"tolerance": math.nan}, "^scene.tolerance: nan"),
    ({"method": {"name": "rk4"}}, "^scene.tolerance.*method"),
    ({"system": "moser_veselov"}, "^scene.tolerance.*discrete"),
], ids=lambda value: None if isinstance(value, str) else "".join(value))
def test_half_a_choice_names_the_field(client, change, fault):
    with pytest.raises(stiefel.InvalidArgument, match=fault):
        client.create(chosen(**change))


def test_what_cannot_be_met_says_the_best_that_was_found(client):
    with pytest.raises(stiefel.InvalidArgument) as refused:
        client.create(chosen(tolerance=1e-15, horizon=100.0))
    assert refused.value.reason == "TOLERANCE_NOT_MET"
    assert 1e-15 < float(refused.value.metadata["best_error"]) < 1e-10
    assert refused.value.metadata["best_method"] in str(refused.value)
    assert refused.value.violations[0].field == "scene.tolerance"
