"""`stiefel diagnose`, and the diagnosis that `stiefel run` prints."""
import re

import numpy as np
import pytest

from conftest import matrix


@pytest.mark.parametrize("command", ["run", "diagnose"])
def test_moments_of_no_body_are_warned_of(stiefel, write, command):
    body = {"moments": [1, 0.5, 2], "angular_velocity": [0.1, 0.2, 0.3]}
    scene = {"system": "rigid_body", "method": {"name": "exact"}, "step": 0.1, "body": body}
    result = stiefel(command, write(scene), "--to", 2)
    assert result.status == 0
    assert result.err == "warning: I1 + I2 = 1.5 < I3 = 2: no rigid body has these moments; are all three in one unit?\n"
    body["moments"] = [1, 0.5, 1.5]
    assert stiefel(command, write(scene), "--to", 2).err == ""


def test_the_summary_of_an_ensemble_names_the_members(stiefel, write):
    """The first member rests at a fixed point, where nothing drifts; the worst drift is the second's."""
    scene = {"system": "rigid_body", "method": {"name": "rk4"}, "step": 0.1, "members": 2,
             "body": {"moments": [1, 2, 3], "angular_velocity": [0, 0, 1, 1, 2, 3]}}
    diagnosis = stiefel("diagnose", write(scene), "--to", 50, "--error").json["diagnosis"]
    worst = max(diagnosis["invariants"], key=lambda invariant: invariant["drift"])
    assert worst["member"] == 1 and worst["drift"] > 1e-9
    assert re.match(rf"invariants kept to \S+ \({re.escape(worst['name'])} of member 1\); ", diagnosis["summary"])
    assert diagnosis["summary"].endswith("of member 1")


def test_diagnose_says_what_run_says(stiefel, write, scene):
    path = write(scene)
    diagnosed, run = stiefel("diagnose", path, "--to", 50), stiefel("run", path, "--to", 50)
    assert diagnosed.status == 0
    assert set(diagnosed.json) == {"outcome", "diagnosis"}
    assert diagnosed.json["diagnosis"] == run.json["diagnosis"]


def test_diagnose_only_what_is_named(stiefel, write, scene):
    result = stiefel("diagnose", write(scene), "--to", 50, "--invariants", "energy,casimirs").json
    names = {re.sub(r"\[.*", "", i["name"]) for i in result["diagnosis"]["invariants"]}
    assert names == {"energy", "casimirs"}


def test_momentum_only_has_no_orthogonality(stiefel, write, scene):
    del scene["initial"]["Q"]
    result = stiefel("run", write(scene), "--to", 5).json
    assert list(result["samples"][0]["fields"]) == ["M"]
    assert "orthogonality" not in result["diagnosis"]


def test_diagnose_structure(stiefel, write, scene):
    zero = matrix(np.zeros((3, 3)))
    asked = {"forms": [{"form": "omega", "first": {"Q": zero, "M": zero}, "second": {"Q": zero, "M": zero}}]}
    done = stiefel("diagnose", write(scene), "--to", 5, "--symplectic", "--structure", write(asked, "forms.json"))
    assert done.status == 0
    assert done.json["diagnosis"]["forms"] == [0] and done.json["diagnosis"]["symplectic_defect"] < 1e-11
    del asked["forms"][0]["second"]["M"]
    done = stiefel("diagnose", write(scene), "--to", 5, "--structure", write(asked, "forms.json"))
    assert done.status == 2 and "--structure: forms[0].second.M" in done.err
