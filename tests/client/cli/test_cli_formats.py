"""The files that `stiefel run` writes: JSON, CSV and NPZ hold the same bits, and a full disk is an error."""
import csv
import os
import subprocess

import numpy as np
import pytest

from conftest import EXAMPLES, SCENES


def bits(values):
    return np.asarray(values, dtype=float).tobytes()


def without_comments(path):
    return [line for line in path.read_text().splitlines() if not line.startswith("#")]


@pytest.mark.parametrize("name", SCENES)
def test_formats_agree_to_the_bit(stiefel, tmp_path, name):
    def run(*more):
        return stiefel("run", EXAMPLES / f"{name}.json", "--to", 700, "--every", 3, "--fields",
                       "Q,M,Omega", *more)
    printed = run()
    assert printed.status == 0
    for extension in ("json", "csv", "npz"):
        result = run("--output", f"out.{extension}")
        assert result.status == 0
        if extension == "json":
            assert result.out == ""
        else:
            assert set(result.json) == {"outcome", "diagnosis"}
            assert result.json["diagnosis"] == printed.json["diagnosis"]
    assert (tmp_path / "out.json").read_text() == printed.out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.csv", "out.json", "out.npz"]

    samples = printed.json["samples"]
    expected = {name: [np.array(s["fields"][name]) for s in samples] for name in ("Q", "M", "Omega")}
    with np.load(tmp_path / "out.npz") as arrays:
        assert arrays.files == ["step", "time", "Q", "M", "Omega", "stiefel"]
        assert arrays["step"].dtype == np.int64
        assert arrays["step"].tolist() == [s["step"] for s in samples]
        assert bits(arrays["time"]) == bits([s["time"] for s in samples])
        for field, values in expected.items():
            assert arrays[field].shape == np.shape(values)
            assert bits(arrays[field]) == bits(values)

    header, *rows = csv.reader(without_comments(tmp_path / "out.csv"))
    assert header[:3] == ["step", "time", "Q[0,0]"]
    n = expected["Q"][0].shape[0]
    assert header[2 + n] == "Q[1,0]" and header[-1] == f"Omega[{n - 1},{n - 1}]"
    assert [int(row[0]) for row in rows] == [s["step"] for s in samples]
    flat = [[s["time"], *(x for f in s["fields"].values() for x in np.ravel(f))] for s in samples]
    assert bits([[float(x) for x in row[1:]] for row in rows]) == bits(flat)


def test_a_float_scene_is_written_as_floats(stiefel, write, scene, tmp_path):
    scene["method"]["scalar"] = "float"
    path = write(scene)
    run = ["run", path, "--to", 20, "--every", 5]
    printed = stiefel(*run)
    assert printed.status == 0
    samples = [np.array(sample["fields"]["Q"]) for sample in printed.json["samples"]]
    assert all(stiefel(*run, "--output", f"out.{extension}").status == 0 for extension in ("npz", "csv"))
    with np.load(tmp_path / "out.npz") as arrays:
        assert arrays["Q"].dtype == np.float32 and arrays["time"].dtype == np.float64
        assert bits(arrays["Q"]) == bits(samples)
    _, *rows = csv.reader(without_comments(tmp_path / "out.csv"))
    assert bits([[float(x) for x in row[2:11]] for row in rows]) == bits(samples)


def test_equal_runs_write_equal_archives(stiefel, write, scene, tmp_path):
    for name in ("a.npz", "b.npz"):
        assert stiefel("run", write(scene), "--to", 5, "--output", name).status == 0
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_file_is_replaced_only_by_a_complete_one(stiefel, write, scene, tmp_path):
    (tmp_path / "out.json").write_text("before")
    assert stiefel("run", write(scene), "--to", 5, "--fields", "nothing",
                   "--output", "out.json").status == 2
    assert (tmp_path / "out.json").read_text() == "before"
    assert not list(tmp_path.glob("*.part*"))


def test_a_full_disk_is_noticed(stiefel, write, scene, tmp_path):
    (tmp_path / "full.csv").symlink_to("/dev/full")
    result = stiefel("run", write(scene), "--to", 5, "--output", "full.csv")
    assert result.status == 1
    assert "No space left" in result.err


def test_a_full_disk_behind_stdout_is_noticed(stiefel):
    with open("/dev/full", "w") as full:
        done = subprocess.run([os.environ["STIEFEL_CLI"], "describe"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert done.stderr == "stiefel: error: cannot write to stdout: No space left on device\n"
