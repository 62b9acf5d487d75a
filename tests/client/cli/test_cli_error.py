"""The estimated error beside the drift."""
import json
import re

import numpy as np
import pytest

from conftest import EXAMPLES, matrix


def test_invariants_kept_is_not_attitude_accurate(stiefel, write):
    """Envisat after 6000 s: order 2 is off by more than a degree, order 10 by nothing; both keep everything."""
    scene = json.loads((EXAMPLES / "envisat.json").read_text())
    second = stiefel("run", write({**scene, "method": {"name": "variational"}}), "--to", 6000, "--every",
                     6000).json["diagnosis"]
    error = second["estimated_error"]
    assert error["attitude_degrees"] == pytest.approx(1.2, abs=0.05)
    assert error["attitude"] == pytest.approx(1.59e-2, rel=0.05) and error["momentum"] > 1e-5
    assert max(i["drift"] for i in second["invariants"]) < 1e-13
    assert error["work"] < error["run_work"] and "closed form" in error["reference"]
    assert re.fullmatch(r"invariants kept to \d.\de-1\d; estimated error at t = 6000: "
                        r"attitude 1.\de-02 \(1.2°\), momentum \d.\de-0\d", second["summary"])
    tenth = stiefel("diagnose", write({**scene, "method": {"name": "preprocessed_variational", "order": 10}}), "--to",
                    6000).json["diagnosis"]["estimated_error"]
    assert 1e-14 < tenth["attitude"] < 2e-12


def test_an_estimate_of_less_than_ten_milliseconds_is_always_there(stiefel, write, scene):
    for to in (1, 2):
        error = stiefel("diagnose", write(scene), "--to", to).json["diagnosis"]["estimated_error"]
        assert "missing" not in error and 0 < error["attitude"] < 1e-3 and error["run_work"] < error["work"] < 5e7


def test_an_estimate_that_costs_more_than_the_run_is_for_those_who_ask(stiefel, write, scene):
    M = np.triu(np.ones((20, 20)), 1)
    large = {"system": "rigid_body", "method": {"name": "rk4"}, "inertia": list(range(1, 21)), "step": 0.01,
             "initial": {"Q": matrix(np.eye(20)), "M": matrix(M - M.T)}}
    path = write(large)
    for command in ("run", "diagnose"):
        shy, asked, never = (stiefel(command, path, "--to", 2, *more).json["diagnosis"]
                             for more in ([], ["--error"], ["--no-error"]))
        assert "attitude" not in shy["estimated_error"]
        assert "would take" in shy["estimated_error"]["missing"] and "would take" in shy["summary"]
        assert 0 < asked["estimated_error"]["attitude"] < 1e-3
        assert asked["estimated_error"]["work"] > asked["estimated_error"]["run_work"]
        assert "estimated_error" not in never and never["summary"].endswith("error at t = 0.02 not estimated")
    assert stiefel("run", path, "--to", 2, "--error", "--no-error").status == 2


def test_the_error_of_a_run_that_stopped_is_that_of_its_last_state(stiefel, write, too_long):
    diagnosis = stiefel("diagnose", write(too_long), "--to", 10, "--error").json["diagnosis"]
    error = diagnosis["estimated_error"]  # the state of the scene itself has an error below that of the reference
    assert error["missing"].startswith("the error is below that of the reference") and error["reference_error"] < 1e-15


def test_a_discrete_system_has_no_error(stiefel):
    diagnosis = stiefel("diagnose", EXAMPLES / "moser_veselov.json", "--to", 5, "--error").json["diagnosis"]
    assert "discrete system" in diagnosis["estimated_error"]["missing"]
