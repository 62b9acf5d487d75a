"""Every JSON output of every command is JSON: NaN and the infinities, which it does not have, are null."""
import json

import numpy as np
import pytest

BODY = {"system": "rigid_body", "method": {"name": "variational"}, "step": 1.0,
        "body": {"moments": [1, 2, 3], "angular_velocity": [0.01, 0.02, 0.01]}}
# The second member leaves the domain of the map at its first step: h |Omega| is about 9.
STOPS = {**BODY, "members": 2, "body": {"moments": [1, 2, 3], "angular_velocity": [0.01, 0.02, 0.01, 5, 6, 5]}}
GEODESIC = {"inertia": [1, 2, 3], "pairs": [{"Q_0": {"rows": 1, "cols": 3, "values": [1, 0, 0]},
                                             "Q_T": {"rows": 1, "cols": 3, "values": [0, 1, 0]}}], "time": 1}
REQUEST = {"quantities": [{"name": "energy", "statistics": ["STATISTIC_DRIFT"], "quantiles": [0.5]},
                          {"name": "M", "statistics": ["STATISTIC_LAST", "STATISTIC_MIN"], "edges": [-1, 0, 1]}],
           "events": [{"field": "angular_velocity", "coefficients": [1, 0, 0]}]}


def strict(text):
    def refuse(constant):
        raise ValueError(f"{constant} is not JSON")
    return json.loads(text, parse_constant=refuse)


@pytest.fixture
def files(write, tmp_path):
    names = {"body": write(BODY, "body.json"), "stops": write(STOPS, "stops.json"), "geodesic": write(GEODESIC, "pairs.json"),
             "request": write(REQUEST, "request.json"), "times": write("0.5 2 7.25", "times.txt"), "out": tmp_path / "out.json"}
    frame = write({"inertia": [1, 2, 3], **GEODESIC["pairs"][0], "time": 1}, "frames.json")
    return {**names, "frame": frame}


@pytest.mark.parametrize("command, status", [
    ("describe --json", 0),
    ("run body --to 20", 0), ("run body --to 20 --output out", 0), ("run body --times times", 0),
    ("run stops --to 20", 3), ("run stops --times times", 3), ("run stops --times times --output out", 3),
    ("diagnose body --to 20 --symplectic --error", 0), ("diagnose stops --to 20", 3),
    ("summarize body --to 20 --request request", 0), ("summarize stops --to 20 --request request", 3),
    ("summarize stops --to 20 --request request --output out", 3),
    ("convert body --to symmetric_rigid_body", 0), ("convert body --to velocity", 0),
    ("convert body --to symmetric_rigid_body --output out", 0), ("convert stops --to velocity", 0),
    ("connect geodesic", 0), ("connect frame", 0),
    ("tradeoff body --budget 1e7 --repeats 1 --output out", 0),
])
def test_every_output_is_json(stiefel, files, command, status):
    done = stiefel(*(files.get(word, word) for word in command.split()))
    assert done.status == status, done.err
    texts = ([] if command.startswith("tradeoff") else [done.out]) + ([files["out"].read_text()] if "out" in command.split() else [])
    for text in filter(None, texts):
        assert strict(text)
    assert any(texts)


def test_a_member_that_has_stopped_is_null(stiefel, files):
    """The members have 9 numbers each in M: those of the first are numbers, those of the second are not."""
    samples = strict(stiefel("run", files["stops"], "--times", files["times"], "--fields", "M").out)["samples"]
    assert [sample["time"] for sample in samples] == [0.5, 2, 7.25]
    values = np.array([sample["fields"]["M"] for sample in samples], dtype=object).reshape(3, 2, 9)
    assert all(isinstance(number, float) for number in values[:, 0].ravel())
    assert all(number is None for number in values[1:, 1].ravel())
