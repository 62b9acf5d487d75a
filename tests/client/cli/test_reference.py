"""The command against solutions in 50 digits (tests/support/reference.json), which share no method
with the engine: flows were extrapolated from the plain vector field, maps iterated with Newton's
method. Every case in every form that the motion has."""
import json
import pathlib

import numpy as np
import pytest

from conftest import matrix

CASES = json.loads((pathlib.Path(__file__).parents[2] / "support/reference.json").read_text())["cases"]
ADAPTIVE = {"name": "adaptive", "tolerance": 1e-13}


def of(system):
    cases = [case for case in CASES if case["system"] == system]
    assert cases
    return pytest.mark.parametrize("case", cases, ids=[case["name"] for case in cases])


def array(rows):
    if isinstance(rows, dict):
        return np.array(rows["re"], dtype=float) + 1j * np.array(rows["im"], dtype=float)
    return np.array(rows, dtype=float)


def block(values):
    if not np.iscomplexobj(values):
        return matrix(values)
    return {**matrix(values.real), "imaginary": values.imag.ravel().tolist()}


def scene(system, case, initial, **rest):
    inertia = {key: [float(x) for x in case[key]] for key in ("inertia", "inertia_u", "inertia_v") if key in case}
    return {"system": system, **inertia, **rest,
            "initial": {name: block(values) for name, values in initial.items()}}


def error(result, expected):
    """The largest of the last sample, relative to the largest entry of its block."""
    assert result.status == 0, result.err
    fields = result.json["samples"][-1]["fields"]

    def of(name, values):
        found = fields[name]
        if isinstance(found, dict):
            found = np.array(found["values"]) + 1j * np.array(found["imaginary"])
        return np.abs(np.reshape(found, values.shape) - values).max() / np.abs(values).max()

    return max(of(name, values) for name, values in expected.items())


@of("moser_veselov")
@pytest.mark.parametrize("system", ["moser_veselov", "symmetric_moser_veselov", "moser_veselov_pair"])
def test_the_discrete_body(stiefel, write, case, system):
    Q0, M0, Q, M = (array(case[name]) for name in ("Q0", "M0", "Q", "M"))
    step, steps = float(case["h"]), case["steps"]
    if system == "moser_veselov_pair":  # the pair that belongs to (Q, M) is one step of the map away
        first = stiefel("run", write(scene("moser_veselov", case, {"Q": Q0, "M": M0}, step=step)), "--to", 1)
        Q1 = np.array(first.json["samples"][-1]["fields"]["Q"])
        path = write(scene(system, case, {"Q_prev": Q0, "Q": Q1}, step=step))
        assert error(stiefel("run", path, "--to", steps - 1, "--fields", "Q"), {"Q": Q}) < 1e-11
    else:
        path = write(scene(system, case, {"Q": Q0, "M": M0}, step=step))
        assert error(stiefel("run", path, "--to", steps, "--fields", "Q,M"), {"Q": Q, "M": M}) < 1e-12


@of("rigid_body")
def test_the_rigid_body(stiefel, write, case):
    """Order 4 with h = t / 16000: 60 / 16000 is the longest, for a motion with h ‖Ω‖ = 0.0038."""
    method = {"name": "munthe_kaas4", "substeps": 1600}
    initial = {"Q": array(case["Q0"]), "M": array(case["M0"])}
    path = write(scene("rigid_body", case, initial, method=method, step=float(case["t"]) / 10))
    assert error(stiefel("run", path, "--to", 10), {"Q": array(case["Q"]), "M": array(case["M"])}) < 1e-10


@of("rigid_body")
@pytest.mark.parametrize("system", ["right_rigid_body", "symmetric_rigid_body", "right_symmetric_rigid_body",
                                    "reduced_rigid_body", "mclachlan_scovel"])
def test_its_other_forms(stiefel, write, case, system):
    Q0, M0, Q, M = (array(case[name]) for name in ("Q0", "M0", "Q", "M"))
    if system.startswith("right"):  # [RB] Prop. 2.1
        Q0, M0, Q, M = Q0.T, -M0, Q.T, -M
    path = write(scene(system, case, {"Q": Q0, "M": M0}, method=ADAPTIVE, step=float(case["t"]) / 50))
    assert error(stiefel("run", path, "--to", 50, "--every", 50, "--fields", "Q,M"), {"Q": Q, "M": M}) < 1e-10


@of("stiefel")
@pytest.mark.parametrize("system", ["stiefel", "stiefel_costate", "stiefel_momentum", "ellipsoid", "ellipsoid costate"])
def test_geodesics(stiefel, write, case, system):
    Q0, S0, Q, S = (array(case[name]) for name in ("Q0", "S0", "Q", "S"))
    Lambda = array(case["inertia"])
    velocity = {"Qdot": S / Lambda}
    if system.startswith("ellipsoid"):
        if len(Q0) > 1:
            pytest.skip("n = 1 only")
        other = {"p": S0} if "costate" in system else {"qdot": S0 / Lambda}
        initial, expected = {"q": Q0, **other}, {"q": Q, **velocity}
    else:
        # Any costate with the same M will do: P = S + kQ, k symmetric.
        k = np.ones((len(Q0), len(Q0)))
        other = {"stiefel": {"S": S0}, "stiefel_costate": {"P": S0 + k @ Q0},
                 "stiefel_momentum": {"M": Q0.T @ S0 - S0.T @ Q0}}[system]
        initial, expected = {"Q": Q0, **other}, {"Q": Q, **velocity}
    fields = ",".join(expected)
    path = write(scene(system.split()[0], case, initial, method=ADAPTIVE, step=float(case["t"]) / 50))
    bound = 1e-9 if "1000" in case["name"] else 1e-10
    assert error(stiefel("run", path, "--to", 50, "--every", 50, "--fields", fields), expected) < bound


@of("double_bracket")
def test_the_double_bracket(stiefel, write, case):
    initial = {"Q": array(case["Q0"]), "P": array(case["P0"])}
    path = write(scene("double_bracket", case, initial, method=ADAPTIVE, step=float(case["t"]) / 50))
    expected = {"Q": array(case["Q"]), "P": array(case["P"])}
    assert error(stiefel("run", path, "--to", 50, "--every", 50), expected) < 1e-10


@of("discrete_stiefel")
def test_the_discrete_map_on_frames(stiefel, write, case):
    path = write(scene("discrete_stiefel", case, {"Q_prev": array(case["Q0"]), "Q": array(case["Q1"])}, step=1))
    expected = {"Q_prev": array(case["Q_prev"]), "Q": array(case["Q"])}
    assert error(stiefel("run", path, "--to", case["steps"]), expected) < 1e-12
