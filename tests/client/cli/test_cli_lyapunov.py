"""`stiefel lyapunov`."""
import json

SCENE = {"system": "rigid_body", "step": 0.1, "method": {"name": "variational"},
         "body": {"moments": [1, 2, 3], "angular_velocity": [0.3, 1, 0.2]}}


def test_a_body_is_regular(stiefel, write):
    found = stiefel("lyapunov", write(SCENE), "--to", 20000, "--every", 5000).json
    assert found["outcome"] == "REACHED" and found["verdict"] == "regular", found["reason"]
    assert len(found["exponents"]) == len(found["errors"]) == 6 and len(found["log_gali"]) == 5
    assert all(abs(exponent) < error for exponent, error in zip(found["exponents"], found["errors"]))
    steps = [result["step"] for result in found["results"]]
    assert steps == sorted(steps) and steps[-1] == 20000 and len(steps) == 4
    assert found["results"][-1]["exponents"] == found["exponents"]


def test_a_run_goes_on_from_its_checkpoint(stiefel, write, tmp_path):
    scene, options = write(SCENE), ("--count", 2, "--seed", 3)
    stiefel("lyapunov", scene, "--to", 1500, *options, "--checkpoint", tmp_path / "growth")
    later = stiefel("lyapunov", scene, "--to", 3000, *options, "--resume", tmp_path / "growth").json
    whole = stiefel("lyapunov", scene, "--to", 3000, *options, "--output", tmp_path / "whole.json")
    assert whole.status == 0 and later == json.loads((tmp_path / "whole.json").read_text())


def test_what_cannot_be_is_refused(stiefel, write, tmp_path):
    scene = write(SCENE)
    done = stiefel("lyapunov", scene, "--to", 10)
    assert done.status == 2 and "--to" in done.err and "20 intervals" in done.err
    done = stiefel("lyapunov", scene, "--to", 2000, "--count", 7)
    assert done.status == 2 and "--count" in done.err and "at most 6" in done.err
    (tmp_path / "no").write_bytes(b"no checkpoint")
    done = stiefel("lyapunov", scene, "--to", 2000, "--resume", tmp_path / "no")
    assert done.status == 2 and "--resume" in done.err
