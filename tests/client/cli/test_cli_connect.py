"""`stiefel connect`."""
import json

import numpy as np

from conftest import EXAMPLES, matrix


def test_connect(stiefel, write):
    frames = {"inertia": [1, 2, 3], "Q_0": matrix([[1, 0, 0]]), "Q_T": matrix([[0, 1, 0]]), "time": 1}
    done = stiefel("connect", write(frames))
    assert done.status == 0 and done.json["shortest"] == "yes" and done.json["residual"] < 1e-11
    assert sorted(done.json["initial"]) == ["Q", "S"]
    run = stiefel("run", write(done.json["scene"], "found.json"), "--to", 1, "--fields", "Q").json
    np.testing.assert_allclose(run["samples"][-1]["fields"]["Q"], [[0, 1, 0]], atol=1e-11)


def test_connect_many_pairs(stiefel, write):
    ends = [[0, 1, 0], [0, 0, 1], [0, 0.6, 0.8]]
    pairs = [{"Q_0": matrix([[1, 0, 0]]), "Q_T": matrix([end])} for end in ends]
    done = stiefel("connect", write({"inertia": [1, 2, 3], "pairs": pairs, "time": 1}))
    assert done.status == 0, done.err
    geodesics = done.json["geodesics"]
    assert len(geodesics) == 3 and all(geodesic["residual"] < 1e-11 for geodesic in geodesics)
    alone = stiefel("connect", write({"inertia": [1, 2, 3], **pairs[1], "time": 1})).json
    assert geodesics[1] == alone
    for end, geodesic in zip(ends, geodesics):
        run = stiefel("run", write(geodesic["scene"], "found.json"), "--to", 1, "--fields", "Q").json
        np.testing.assert_allclose(run["samples"][-1]["fields"]["Q"], [end], atol=1e-11)


def test_a_fault_is_where_the_file_has_it(stiefel, write):
    """By the name in the file: of a pair alone without a list, else with its index."""
    good, bad = matrix([[1, 0, 0]]), matrix([[0, 2, 0]])
    alone = stiefel("connect", write({"inertia": [1, 2, 3], "Q_0": good, "Q_T": bad, "time": 1}))
    assert alone.status == 2 and "scene.json: Q_T" in alone.err and "pairs" not in alone.err
    pairs = [{"Q_0": good, "Q_T": good}, {"Q_0": good, "Q_T": bad}]
    many = stiefel("connect", write({"inertia": [1, 2, 3], "pairs": pairs, "time": 1}))
    assert many.status == 2 and "scene.json: pairs[1].Q_T" in many.err
    both = stiefel("connect", write({"inertia": [1, 2, 3], "pairs": pairs, "Q_0": good, "time": 1}))
    assert both.status == 2 and "scene.json: pairs: must be absent when Q_0 or Q_T is given" in both.err
    canonical = stiefel("connect", write({"metric": "METRIC_BETA", "pairs": pairs[:1], "time": 1}))
    assert canonical.status == 2 and "scene.json: beta: " in canonical.err


def test_a_metric_without_a_scene_has_a_velocity(stiefel, write):
    Q_0, Q_T = np.eye(2, 5), np.eye(5)[[4, 1]]
    done = stiefel("connect", write({"metric": "METRIC_CANONICAL", "Q_0": matrix(Q_0), "Q_T": matrix(Q_T), "time": 1}))
    assert done.status == 0 and "scene" not in done.json and done.json["residual"] < 1e-11
    np.testing.assert_allclose(done.json["velocity"], [[0, 0, 0, 0, np.pi / 2], [0, 0, 0, 0, 0]], atol=1e-13)


def test_connect_names_what_is_wrong(stiefel, write):
    frames = {"inertia": [1, 2, 3], "Q_0": matrix(np.eye(3)), "Q_T": matrix(np.diag([1, 1, -1])), "time": 1}
    done = stiefel("connect", write(frames))
    assert done.status == 2 and "det Q_T = -1" in done.err


def test_the_example_file_has_frames_as_lists_of_rows(stiefel, write):
    given = json.loads((EXAMPLES / "frames.json").read_text())
    done = stiefel("connect", EXAMPLES / "frames.json")
    assert done.status == 0 and done.json["residual"] < 1e-11
    scene = {**done.json["scene"], "step": given["time"]}
    run = stiefel("run", write(scene, "found.json"), "--to", 1, "--fields", "Q").json
    np.testing.assert_allclose(run["samples"][-1]["fields"]["Q"], given["Q_T"], atol=1e-8)
    objects = {**given, "Q_0": matrix(given["Q_0"]), "Q_T": matrix(given["Q_T"])}
    assert stiefel("connect", write(objects)).json == done.json
    pairs = [{"Q_0": given["Q_0"], "Q_T": given["Q_T"]}]
    assert stiefel("connect", write({"inertia": given["inertia"], "time": 2, "pairs": pairs})).json["geodesics"] == [done.json]
    ragged = stiefel("connect", write({**given, "Q_T": [[0, 0, 1, 0], [0, 1]]}))
    assert ragged.status == 2 and "scene.json: Q_T: must be rows of one length" in ragged.err
