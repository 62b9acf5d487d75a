"""What `stiefel run` samples, and the JSON that it prints."""
import numpy as np
import pytest

from conftest import EXAMPLES, SCENES, matrix


def steps(result):
    return [sample["step"] for sample in result.json["samples"]]


def test_samples_from_every_and_always_the_last(stiefel, write, scene):
    path = write(scene)
    assert steps(stiefel("run", path, "--to", 11, "--from", 2, "--every", 4)) == [2, 6, 10, 11]
    assert steps(stiefel("run", path, "--to", 0)) == [0]


def test_without_every_a_long_run_gives_its_two_ends(stiefel, write, scene):
    path = write(scene)
    assert len(steps(stiefel("run", path, "--to", 999))) == 1000
    assert steps(stiefel("run", path, "--to", 1000)) == [0, 1000]
    assert steps(stiefel("run", path, "--from", 1, "--to", 1000)) == list(range(1, 1001))


def test_and_says_so_where_no_data_are(stiefel, write, scene, tmp_path):
    path, said = write(scene), "stiefel: wrote 2 samples (first and last); --every 1 for all\n"
    assert stiefel("run", path, "--to", 10000, "--output", tmp_path / "x.npz").err == said
    told = stiefel("run", path, "--to", 1000)
    assert told.err == said and steps(told) == [0, 1000]
    for quiet in (["--to", 999], ["--to", 1000, "--every", 1000]):
        assert stiefel("run", path, *quiet).err == ""


def test_the_json_is_the_documented_one(stiefel, write, scene):
    result = stiefel("run", write(scene), "--to", 2, "--fields", "Q,quaternion").json
    assert list(result) == ["samples", "outcome", "diagnosis", "estimated_error", "format", "numerics_id", "scene", "run",
                            "fields", "units"]
    assert result["outcome"] == "REACHED" and result["run"] == {"to": 2, "start": 0, "every": 1, "fields": ["Q", "quaternion"]}
    sample = result["samples"][2]
    assert set(sample) == {"step", "time", "fields"}
    assert type(sample["step"]) is int and sample["time"] == 0.02
    assert list(sample["fields"]) == ["Q", "quaternion"]
    assert np.shape(sample["fields"]["Q"]) == (3, 3) and np.shape(sample["fields"]["quaternion"]) == (4,)
    assert result["scene"]["initial"]["M"] == [[0, -0.01, 3], [0.01, 0, -0.001], [-3, 0.001, 0]]
    diagnosis = result["diagnosis"]
    assert set(diagnosis) == {"summary", "invariants", "orthogonality", "estimated_error", "domain"}
    for invariant in diagnosis["invariants"]:
        assert set(invariant) == {"name", "initial", "value", "drift", "scale", "conservation"}
        assert invariant["conservation"] in ("exact", "bounded", "drifts")
    assert set(diagnosis["domain"]) == {"h_omega", "largest_step"}


def test_what_goes_in_comes_out_at_step_0_to_the_bit(stiefel, write, scene):
    M = [[0, 0.1, -1e-300], [-0.1, 0, 1 / 3], [1e-300, -1 / 3, 0]]
    scene["initial"]["M"] = matrix(M)
    fields = stiefel("run", write(scene), "--to", 0).json["samples"][0]["fields"]
    assert fields["M"] == M


@pytest.mark.parametrize("name", SCENES)
def test_examples_run_and_keep_what_they_should(stiefel, name):
    result = stiefel("run", EXAMPLES / f"{name}.json", "--to", 2000, "--every", 500)
    assert result.status == 0, result.err
    diagnosis = result.json["diagnosis"]
    exact = all(i["conservation"] == "exact" for i in diagnosis["invariants"])
    assert diagnosis["orthogonality"] < (1e-13 if exact else 1e-9)
    assert all(i["drift"] < (1e-13 if i["conservation"] == "exact" else 1e-9) for i in diagnosis["invariants"])
