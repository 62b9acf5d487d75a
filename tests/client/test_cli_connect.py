"""`stiefel connect`."""
import numpy as np

from conftest import matrix


def test_connect(stiefel, write):
    frames = {"inertia": [1, 2, 3], "Q_0": matrix([[1, 0, 0]]), "Q_T": matrix([[0, 1, 0]]), "time": 1}
    done = stiefel("connect", write(frames))
    assert done.status == 0 and done.json["shortest"] == "unknown" and done.json["residual"] < 1e-11
    assert sorted(done.json["initial"]) == ["Q", "S"]
    run = stiefel("run", write(done.json["scene"], "found.json"), "--to", 1, "--fields", "Q").json
    np.testing.assert_allclose(run["samples"][-1]["fields"]["Q"]["values"], [0, 1, 0], atol=1e-11)


def test_connect_names_what_is_wrong(stiefel, write):
    frames = {"inertia": [1, 2, 3], "Q_0": matrix(np.eye(3)), "Q_T": matrix(np.diag([1, 1, -1])), "time": 1}
    done = stiefel("connect", write(frames))
    assert done.status == 2 and "det Q_T = -1" in done.err
