"""A run that ends before its last step: status 3, and what was reached is written."""
import json
import re

import numpy as np
import pytest


@pytest.mark.parametrize("extension", ["json", "csv", "npz"])
def test_a_stop_is_status_3_and_the_file_is_written(stiefel, write, too_long, tmp_path, extension):
    result = stiefel("run", write(too_long), "--to", 10, "--output", f"out.{extension}")
    assert result.status == 3
    assert result.err.startswith("stiefel: LEFT_DOMAIN after step 0: ")
    report = json.loads((tmp_path / "out.json").read_text()) if extension == "json" else result.json
    assert report["outcome"] == "LEFT_DOMAIN"
    assert 0 < report["largest_step"] < 5
    assert report["message"]
    assert (tmp_path / f"out.{extension}").exists()


def test_the_largest_step_works_and_a_longer_one_does_not(stiefel, write, too_long):
    largest = stiefel("run", write(too_long), "--to", 1).json["largest_step"]
    assert stiefel("run", write({**too_long, "step": largest}), "--to", 1).status == 0
    assert stiefel("run", write({**too_long, "step": 1.002 * largest}), "--to", 1).status == 3


def test_diagnose_a_stop(stiefel, write, too_long):
    result = stiefel("diagnose", write(too_long), "--to", 10)
    assert result.status == 3
    assert result.json["outcome"] == "LEFT_DOMAIN"
    assert result.json["diagnosis"]["invariants"]


def test_a_stop_says_by_which_angle_the_step_turns(stiefel, write, too_long):
    """By 5 ‖Omega‖, Omega_ij = M_ij / (lambda_i + lambda_j)."""
    for command in ("run", "diagnose"):
        result = stiefel(command, write(too_long), "--to", 10)
        angle = np.degrees(5.0 * np.hypot(3 / 3.0, np.hypot(0.01 / 4.0, 0.001 / 2.0)))
        asked, largest = re.search(r"the step of 5 turns the body by (\d+)° and has no solution on the principal branch; "
                                   r"the largest .* which turns it by ([\d.]+)°", result.json["message"]).groups()
        assert float(asked) == pytest.approx(angle, rel=6e-3)
        assert float(largest) == pytest.approx(result.json["largest_step"] / 5.0 * angle, rel=6e-3)
        assert result.json["message"] in result.err
