"""`stiefel rerun`: a file of samples holds its scene, and the scene gives its samples again."""
import json
import os
import pty
import re

import numpy as np
import pytest

from conftest import EXAMPLES

BODY = EXAMPLES / "tumbling_spacecraft.json"
EXTENSIONS = ["npz", "csv", "json"]


def description(path):
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return json.loads(bytes(arrays["stiefel"].item()))
    if path.suffix == ".json":
        return json.loads(path.read_text())
    lines = [line for line in path.read_text().splitlines() if line.startswith("# {")]
    return {**json.loads(lines[0][2:]), **json.loads(lines[1][2:])}


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("run", [["--to", 40, "--every", 3], ["--to", 40, "--from", 7, "--every", 10, "--fields", "Q,momentum_space"],
                                 ["--times", "times.txt"]])
def test_a_file_is_run_again(stiefel, tmp_path, extension, run):
    (tmp_path / "times.txt").write_text("0.5 0 17.25 3")
    file = tmp_path / f"out.{extension}"
    assert stiefel("run", BODY, *run, "--output", file.name).status == 0
    found = description(file)
    assert found["format"] == "stiefel.trajectory" and found["scene"]["method"]["name"] == "exact" and found["outcome"] == "REACHED"
    assert found["units"]["time"] == "s" and found["estimated_error"]["reference"] and len(found["numerics_id"]) == 16
    again = stiefel("rerun", file.name)
    assert again.status == 0 and again.out == f"out.{extension}: the same samples, to the last bit\n"
    assert stiefel("rerun", file.name, "--output", f"again.{extension}").status == 0
    assert (tmp_path / f"again.{extension}").read_bytes() == file.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir() if path.suffix != ".txt") == [f"again.{extension}", f"out.{extension}"]


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_a_run_that_stopped_stops_again(stiefel, write, tmp_path, extension):
    scene = {"system": "rigid_body", "step": 1.5, "method": {"name": "rk4"}, "body": {"moments": [1, 2, 3], "angular_velocity": [0.1, 2, 0.1]}}
    assert stiefel("run", write(scene), "--to", 100, "--output", f"out.{extension}").status == 3
    assert description(tmp_path / f"out.{extension}")["outcome"] == "NOT_FINITE"
    again = stiefel("rerun", f"out.{extension}")
    assert again.status == 3 and "the same samples" in again.out


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_other_samples_are_told(stiefel, tmp_path, extension):
    file = tmp_path / f"out.{extension}"
    assert stiefel("run", BODY, "--to", 4, "--output", file.name).status == 0
    if extension == "npz":
        with np.load(file) as arrays:
            changed = dict(arrays)
        changed["quaternion"][2, 0] = np.nextafter(changed["quaternion"][2, 0], 2)
        np.savez(file, **changed)
    elif extension == "json":
        changed = json.loads(file.read_text())
        values = changed["samples"][2]["fields"]["quaternion"]
        values[0] = np.nextafter(values[0], 2)
        file.write_text(json.dumps(changed))
    else:
        lines = file.read_text().splitlines()
        step, time, first, rest = lines[5].split(",", 3)
        lines[5] = ",".join([step, time, repr(float(np.nextafter(float(first), 2))), rest])
        file.write_text("\n".join(lines) + "\n")
    again = stiefel("rerun", file.name)
    assert again.status == 1 and again.out == f"out.{extension}: other samples\n"


def test_what_the_python_client_saved_is_run_again(stiefel, tmp_path):
    client = pytest.importorskip("stiefel")
    run = client.simulate(json.loads(BODY.read_text()), to=30, every=4, fields=["quaternion", "Q"])
    for extension in EXTENSIONS:
        run.save(tmp_path / f"out.{extension}")
        again = stiefel("rerun", f"out.{extension}")
        assert again.status == 0 and "the same samples" in again.out, again
        assert stiefel("run", BODY, "--to", 30, "--every", 4, "--fields", "quaternion,Q", "--output", f"cli.{extension}").status == 0
        assert client.load(tmp_path / f"cli.{extension}") == run == client.rerun(tmp_path / f"cli.{extension}")


@pytest.mark.parametrize("extension", ["npz", "csv"])
def test_a_file_of_samples_is_no_scene(stiefel, extension):
    file = f"out.{extension}"
    assert stiefel("run", BODY, "--to", 3, "--output", file).status == 0
    again = stiefel("run", file, "--to", 3)
    assert again.status == 2 and again.err.endswith("; a file of samples is for stiefel rerun\n"), again.err


@pytest.mark.parametrize("name, text, why", [
    ("none.npz", None, "cannot be read"), ("other.npz", "no archive", "is not a file that stiefel run --output wrote"),
    ("other.json", "[1]", "is not a file"), ("other.csv", "step,time\n", "is not a file"), ("other.txt", "", "must end in .json, .csv or .npz"),
    ("broken.json", '{"format": "stiefel.trajectory", "samples": []}', "no scene"),
    ("wrong.json", '{"format": "stiefel.trajectory", "samples": [], "scene": {"sistem": 1}, "run": {}, "numerics_id": ""}', "run: "),
])
def test_another_file_is_refused(stiefel, tmp_path, name, text, why):
    if text is not None:
        (tmp_path / name).write_text(text)
    result = stiefel("rerun", name)
    assert result.status == 2 and name in result.err and (why in result.err or "unknown field" in result.err)


def test_a_diagnosis_on_a_terminal_is_a_table(tmp_path):
    """JSON where stdout is no terminal, or with --json."""
    import subprocess

    def on_terminal(*more, command="diagnose"):
        ours, theirs = pty.openpty()
        done = subprocess.run([os.environ["STIEFEL_CLI"], command, BODY, "--to", "100", *more], stdout=theirs, stderr=subprocess.PIPE)
        os.close(theirs)
        text = b""
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:
                break
            if not part:
                break
            text += part
        os.close(ours)
        assert done.returncode == 0
        return text.decode().replace("\r\n", "\n")

    table = on_terminal()
    assert table.startswith("REACHED at step 100, time ") and "spatial_momentum[0,1]" in table and "estimated error at t = " in table
    assert len({line.index("exact") for line in table.splitlines() if " exact" in line}) == 1
    digits = [number.partition("e")[0].replace(".", "").lstrip("-0") for number in re.findall(r"-?\d[\d.]*(?:e[-+]\d+)?", table)]
    assert 4 < max(map(len, digits)) <= 6
    assert json.loads(on_terminal("--json"))["outcome"] == "REACHED"
    for more in ([], ["--every", "1"]):
        assert on_terminal("--output", tmp_path / "run.csv", *more, command="run") == table


def test_a_file_of_an_earlier_version_is_run_again(stiefel, write, scene, tmp_path):
    """In which a field was an object with rows, cols and values, as a block of a scene may be."""
    assert stiefel("run", write(scene), "--to", 6, "--fields", "Q,quaternion", "--output", "out.json").status == 0
    new = json.loads((tmp_path / "out.json").read_text())
    old = json.loads((tmp_path / "out.json").read_text())
    for sample in old["samples"]:
        sample["fields"] = {"Q": {"rows": 3, "cols": 3, "values": sum(sample["fields"]["Q"], [])},
                            "quaternion": {"rows": 1, "cols": 4, "values": sample["fields"]["quaternion"]}}
    old["scene"]["initial"] = {name: {"rows": 3, "cols": 3, "values": sum(block, [])} for name, block in old["scene"]["initial"].items()}
    (tmp_path / "old.json").write_text(json.dumps(old))
    again = stiefel("rerun", "old.json", "--output", "again.json")
    assert again.status == 0 and "the same samples" in again.out, again
    assert json.loads((tmp_path / "again.json").read_text()) == new
