"""`stiefel summarize`, and `stiefel run --times`."""
import json

import numpy as np
import pytest


def test_statistics_are_those_of_the_samples(stiefel, write, scene):
    path = write(scene)
    result = stiefel("summarize", path, "--to", 100, "--every", 3, "--quantity", "energy=drift,last",
                     "--quantity", "M=min,max,sign_changes")
    assert result.status == 0, result.err
    samples = stiefel("run", path, "--to", 100, "--every", 3, "--fields", "M").json["samples"]
    M = np.reshape([sample["fields"]["M"] for sample in samples], (-1, 9))
    found = result.json
    assert found["outcome"] == "REACHED" and found["last_step"] == 100 and found["samples"] == len(M) == 35
    assert found["statistics"]["M.min"] == M.min(0).reshape(3, 3).tolist()
    assert found["statistics"]["M.max"] == M.max(0).reshape(3, 3).tolist()
    assert 0 <= found["statistics"]["energy.drift"] < 1e-12


def test_statistics_and_events_are_nested_lists_of_the_shapes_in_python(stiefel, write):
    """A vector is a list, of an ensemble one for each member; quantiles and bins stand behind; complex numbers are two lists."""
    body = {"moments": [1, 2, 3], "angular_velocity": [0.1, 1, 0.1]}
    scene = {"system": "rigid_body", "step": 0.1, "body": body}
    request = {"quantities": [{"name": "quaternion", "statistics": ["STATISTIC_LAST"], "quantiles": [0.1, 0.9]},
                              {"name": "spatial_momentum", "statistics": ["STATISTIC_LAST"]}], "fields": ["quaternion", "Q"],
               "events": [{"field": "angular_velocity", "coefficients": [1, 0, 0], "level": 0.05, "limit": 1}]}
    path = write(request, "request.json")
    for given, members in ((scene, []), ({**scene, "members": 2}, [2])):
        found = stiefel("summarize", write(given), "--to", 400, "--request", path).json
        shapes = {name: list(np.shape(values)) for name, values in found["statistics"].items()}
        assert shapes == {"quaternion.last": [*members, 4], "quaternion.quantiles": [*members, 4, 2],
                          "spatial_momentum.last": [*members, 3]}
        assert np.shape(found["last_step"]) == tuple(members)
        assert {name: np.shape(values) for name, values in found["events"][0]["fields"].items()} == {"quaternion": (4,), "Q": (3, 3)}
    wide = stiefel("summarize", "double_bracket", "--to", 3, "--quantity", "Q=last").json["statistics"]["Q.last"]
    last = stiefel("run", "double_bracket", "--to", 3, "--every", 3, "--fields", "Q").json["samples"][-1]["fields"]["Q"]
    assert wide == last and set(wide) == {"values", "imaginary"}


def test_a_request_has_events_and_quantiles(stiefel, write, scene):
    request = {"quantities": [{"name": "M", "quantiles": [0.5], "edges": [-4, 0, 4]}], "fields": ["M"],
               "events": [{"field": "M", "coefficients": [0, 0, 1] + 6 * [0], "direction": "DIRECTION_RISING", "limit": 2}]}
    result = stiefel("summarize", write(scene), "--to", 40_000, "--request", write(request, "request.json"))
    assert result.status == 0, result.err
    found = result.json
    assert np.shape(found["statistics"]["M.quantiles"]) == (3, 3, 1)
    assert np.shape(found["statistics"]["M.histogram"]) == (3, 3, 2)
    assert len(found["events"]) == 2
    for event in found["events"]:
        assert event["event"] == 0 and event["step"] * 0.01 <= event["time"] <= (event["step"] + 1) * 0.01
        assert abs(event["fields"]["M"][0][2]) < 1e-12


def test_an_ensemble_has_outcomes(stiefel, write, scene, tmp_path):
    two = {**scene, "members": 2, "initial": {
        name: {"rows": 6, "cols": 3, "values": 2 * block["values"]} for name, block in scene["initial"].items()}}
    result = stiefel("summarize", write(two), "--to", 10, "--quantity", "energy=mean", "--over-members",
                     "--output", tmp_path / "out.json")
    assert result.status == 0 and result.out == ""
    found = json.loads((tmp_path / "out.json").read_text())
    assert found["outcomes"] == ["REACHED", "REACHED"] and found["last_step"] == [10, 10]
    assert found["statistics"]["energy.mean"] > 0


@pytest.mark.parametrize("arguments, message", [
    (["--quantity", "energy"], "must be NAME=STATISTIC"),
    (["--quantity", "energy=drfit"], "must name last, min"),
    ([], "give --quantity"),
    (["--quantity", "enrgy=drift"], "did you mean"),
    (["--quantity", "M=min", "--every", 0], "must be positive"),
    (["--quantity", "M=min", "--from", 20], "--to"),
])
def test_bad_input_is_told(stiefel, write, scene, arguments, message):
    result = stiefel("summarize", write(scene), "--to", 10, *arguments)
    assert result.status == 2 and message in result.err and result.out == ""


def test_a_stop_is_an_outcome(stiefel, write, too_long):
    result = stiefel("summarize", write(too_long), "--to", 10, "--quantity", "M=last")
    assert result.status == 3 and result.json["outcome"] == "LEFT_DOMAIN" and result.json["last_step"] == 0


def test_samples_at_times(stiefel, write, scene):
    path, times = write(scene), write("0.2 0.015\n0.03\n0.1234", "times.txt")
    result = stiefel("run", path, "--times", times, "--fields", "M")
    assert result.status == 0, result.err
    samples = result.json["samples"]
    assert [sample["time"] for sample in samples] == [0.015, 0.03, 0.1234, 0.2]
    assert [sample["step"] for sample in samples] == [1, 3, 12, 20]
    steps = stiefel("run", path, "--to", 20, "--fields", "M").json["samples"]
    assert samples[1]["fields"] == steps[3]["fields"] and samples[3]["fields"] == steps[20]["fields"]
    assert "diagnosis" in result.json


def test_a_time_that_is_a_multiple_to_rounding_is_that_step(stiefel, write, scene):
    """The first and the last of times, too: 35 * 0.01 is 0.35000000000000003 in doubles."""
    for text, steps in (("0.35", [35]), ("0.57 0.58 1.13", [57, 58, 113]), ("1e-310 0.07", [0, 7])):
        result = stiefel("run", write({**scene, "step": 0.01}), "--times", write(text, "times.txt"), "--fields", "M")
        assert result.status == 0, result.err
        assert [sample["step"] for sample in result.json["samples"]] == steps


@pytest.mark.parametrize("text, message", [
    ("", "has no times"), ("1 x", "--times[1]: x is not a finite number"),
    ("0.2 1e300 0.1", "--times[1]: 1e+300: must be within 2^53 steps"),
])
def test_bad_times_are_told(stiefel, write, scene, text, message):
    result = stiefel("run", write(scene), "--times", write(text, "times.txt"))
    assert result.status == 2 and message in result.err


def test_a_refused_time_has_its_index_in_the_file(stiefel, write):
    """More states between two steps than a call may have, in descending order: the first of them in the motion that is
    one too many is the server's times[1026]."""
    M = np.zeros((64, 64))
    M[0, 1], M[1, 0] = 1, -1
    scene = {"system": "rigid_body", "method": {"name": "rk4"}, "step": 1, "inertia": list(range(1, 65)),
             "initial": {name: {"rows": 64, "cols": 64, "values": block.ravel().tolist()}
                         for name, block in (("Q", np.eye(64)), ("M", M))}}
    times = [2 - 1e-4 * k for k in range(1, 1100)] + [0.5, 1]
    result = stiefel("run", write(scene), "--times", write(" ".join(map(repr, times)), "times.txt"))
    k = 1098 - 1024  # 0.5, 1, and 1024 allowed times between two steps come before it
    assert result.status == 2 and f"--times[{k}]: {times[k]!r}: the states between two steps" in result.err, result.err


def test_a_run_needs_an_end(stiefel, write, scene):
    result = stiefel("run", write(scene))
    assert result.status == 2 and "--to" in result.err
    assert stiefel("run", write(scene), "--to", 3, "--times", write("1", "times.txt")).status == 2


def test_times_need_a_step(stiefel, write, scene):
    result = stiefel("run", write({name: scene[name] for name in scene if name != "step"}),
                     "--times", write("1", "times.txt"))
    assert result.status == 2 and "step: absent" in result.err


@pytest.mark.parametrize("extra", [{"from": 3}, {"to": 7}, {"every": 2}, {"times": [0.1]}])
def test_a_request_says_nothing_that_an_option_says(stiefel, write, scene, extra):
    request = write({"quantities": [{"name": "energy", "statistics": ["STATISTIC_LAST"]}], **extra}, "request.json")
    result = stiefel("summarize", write(scene), "--to", 10, "--request", request)
    assert result.status == 2 and f"{next(iter(extra))}: must be absent" in result.err
