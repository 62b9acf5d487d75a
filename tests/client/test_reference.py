"""The command against solutions in 50 digits (tests/support/reference.json), which share no method
with the engine: flows were extrapolated from the plain vector field, maps iterated with Newton's
method."""
import json
import pathlib

import numpy as np
import pytest

from conftest import matrix

CASES = json.loads((pathlib.Path(__file__).parents[1] / "support/reference.json").read_text())["cases"]


def of(system):
    cases = [case for case in CASES if case["system"] == system]
    assert cases
    return pytest.mark.parametrize("case", cases, ids=[case["name"] for case in cases])


def scene(case, **rest):
    return {"system": case["system"], "inertia": [float(x) for x in case["inertia"]],
            "initial": {"Q": matrix(case["Q0"]), "M": matrix(case["M0"])}, **rest}


def errors(result, case):
    """Of the last sample, block by block, relative to the largest entry."""
    fields = result.json["samples"][-1]["fields"]
    for name in "QM":
        expected = np.array(case[name], dtype=float)
        found = np.reshape(fields[name]["values"], expected.shape)
        yield np.abs(found - expected).max() / np.abs(expected).max()


@of("moser_veselov")
def test_the_map(stiefel, write, case):
    path = write(scene(case, step=float(case["h"])))
    result = stiefel("run", path, "--to", case["steps"])
    assert result.status == 0
    assert max(errors(result, case)) < 1e-12


@of("rigid_body")
def test_the_flow(stiefel, write, case):
    """Order 4 with h = t / 16000: 60 / 16000 is the longest, for a motion with h ‖Ω‖ = 0.0038."""
    method = {"name": "munthe_kaas4", "substeps": 1600}
    path = write(scene(case, method=method, step=float(case["t"]) / 10))
    result = stiefel("run", path, "--to", 10)
    assert result.status == 0
    assert max(errors(result, case)) < 1e-10
