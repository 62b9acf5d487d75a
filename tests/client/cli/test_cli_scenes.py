"""Where a scene comes from (a file, an example, stdin, changes), and where its run ends (a step, a time, the horizon)."""
import json
import math
import os
import subprocess

import numpy as np
import pytest

from conftest import EXAMPLES

#: omega_x = 0.3 cos(t / 2): for I = (2, 2, 1), I omega' = I omega x omega gives omega_x' = omega_y omega_z / 2 and so on.
TOP = {"system": "rigid_body", "step": 0.1, "body": {"moments": [2, 2, 1], "angular_velocity": [0.3, 0, 1]}}
NAMES = sorted(file.stem for file in EXAMPLES.glob("*.json"))


def omega(result):
    return {sample["time"]: sample["fields"]["angular_velocity"] for sample in result.json["samples"]}


def test_every_example_is_in_the_command(stiefel):
    assert len(NAMES) > 20
    for name in NAMES:
        command = ["connect", name] if name == "frames" else ["run", name, "--to", 2]
        from_name, from_file = (stiefel(*[EXAMPLES / f"{name}.json" if one == name else one for one in command]), stiefel(*command))
        assert from_name.status == 0 and from_name.out == from_file.out, from_name.err


def test_without_an_end_a_scene_runs_to_its_horizon(stiefel, write):
    assert stiefel("run", "toutatis").json["samples"][-1]["time"] == 2592000
    assert list(omega(stiefel("run", write({**TOP, "horizon": 0.3})))) == [0, 0.1, 0.2, pytest.approx(0.3)]
    backwards = write({**TOP, "horizon": 0.2, "step": -0.1})
    assert list(omega(stiefel("run", backwards))) == [0, -0.1, -0.2]
    result = stiefel("run", write(TOP))
    assert result.status == 2 and "--to is required, or --time: the scene has no horizon" in result.err


@pytest.mark.parametrize("options, times", [
    (["--time", 0.3], [0, 0.1, 0.2, 0.3]), (["--time", "1.0", "--every", 5], [0, 0.5, 1]), (["--time", 0.25], [0, 0.1, 0.2, 0.25]),
    (["--time", 0.55, "--from", 1, "--every", 3], [0.1, 0.4, 0.55]), (["--to", "2e0"], [0, 0.1, 0.2])])
def test_a_time_is_an_end_of_its_own(stiefel, write, options, times):
    found = omega(stiefel("run", write(TOP), *options))
    assert np.allclose(list(found), times, rtol=0, atol=1e-15)
    for time, values in found.items():
        assert values[0] == pytest.approx(0.3 * math.cos(time / 2), abs=1e-15)


@pytest.mark.parametrize("step", [0.1, -0.1])
def test_times_may_be_on_both_sides_of_0(stiefel, write, tmp_path, step):
    times = [0.7, -0.35, 0, -0.2, 0.05, -1.0]
    (tmp_path / "times.txt").write_text(" ".join(map(str, times)))
    result = stiefel("run", write({**TOP, "step": step}), "--times", "times.txt")
    found = omega(result)
    assert list(found) == sorted(times, reverse=step < 0), result.err
    assert [sample["step"] for sample in result.json["samples"]] == [math.trunc(round(abs(time) / 0.1, 9)) * (1 if time * step >= 0 else -1)
                                                                     for time in found]
    for time, values in found.items():
        assert values[0] == pytest.approx(0.3 * math.cos(time / 2), abs=1e-15)
    pair = json.loads((EXAMPLES / "moser_veselov_pair.json").read_text())
    result = stiefel("run", write(pair, "pair.json"), "--times", "times.txt")
    assert result.status == 2 and "--times[3]: -0.2: must have the sign of the scene's step, because the state 0" in result.err


def test_times_of_other_commands_are_those_of_steps(stiefel, write):
    path = write(TOP)
    assert stiefel("diagnose", path, "--time", 0.3).out == stiefel("diagnose", path, "--to", 3).out
    summary = stiefel("summarize", path, "--time", 0.3, "--quantity", "angular_velocity=last").json
    assert summary["statistics"]["angular_velocity.last"][0] == pytest.approx(0.3 * math.cos(0.15), abs=1e-15)
    for options, told in ((["--time", 0.25], "whole number of steps of 0.1 s; the states next to it are at 0.2 and 0.3"),
                          (["--time", -1], "must be in the direction of the scene's step"), (["--time", 1, "--to", 1], "--to excludes --time")):
        result = stiefel("diagnose", path, *options)
        assert result.status == 2 and told in result.err.splitlines()[0]


def test_a_change_is_that_of_the_file(stiefel, write):
    path = write({**TOP, "initial": None})
    for changes, scene in (
            (["body.angular_velocity=0.1,0,2"], {**TOP, "body": {"moments": [2, 2, 1], "angular_velocity": [0.1, 0, 2]}}),
            (["method.name=rk4", "method.substeps=3", "step=0.05"], {**TOP, "method": {"name": "rk4", "substeps": 3}, "step": 0.05}),
            (['body={"moments": [1, 2, 3], "angular_velocity": [1, 0, 0]}'],
             {**TOP, "body": {"moments": [1, 2, 3], "angular_velocity": [1, 0, 0]}}),
            (["body=null", "inertia=1,2,3", "initial.Q=[[1,0,0],[0,1,0],[0,0,1]]", "initial.M=[[0,1,2],[-1,0,3],[-2,-3,0]]"],
             {"system": "rigid_body", "step": 0.1, "inertia": [1, 2, 3],
              "initial": {"Q": {"rows": 3, "cols": 3, "values": [1, 0, 0, 0, 1, 0, 0, 0, 1]}, "M": [[0, 1, 2], [-1, 0, 3], [-2, -3, 0]]}})):
        options = [word for change in changes for word in ("--set", change)]
        assert stiefel("run", path, "--to", 2, *options).out == stiefel("run", write(scene, "other.json"), "--to", 2).out, changes


@pytest.mark.parametrize("change, told", [
    ("bodi.moments=1,2,3", "with --set: bodi: unknown field; did you mean body?"), ("step=soon", "with --set: step: \"soon\": must be a number"),
    ("step", "--set step: must be FIELD=VALUE"), ("=3", "--set =3: must be FIELD=VALUE"), ("step.length=3", "length would be inside"),
    ("method.name=rk5", "must be one of variational")])
def test_a_wrong_change_is_refused(stiefel, write, change, told):
    result = stiefel("run", write(TOP), "--to", 1, "--set", change)
    assert result.status == 2 and told in result.err and len(result.err.splitlines()) == 1


def test_a_scene_and_frames_come_from_stdin(stiefel, write, tmp_path):
    frames = (EXAMPLES / "frames.json").read_text()
    for command, text, file in ((["run", "-", "--to", "2"], json.dumps(TOP), write(TOP)), (["connect", "-"], frames, "frames")):
        done = subprocess.run([os.environ["STIEFEL_CLI"], *command], input=text, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0 and done.stdout == stiefel(*[file if word == "-" else word for word in command]).out
    done = subprocess.run([os.environ["STIEFEL_CLI"], "run", "-", "--to", "2"], input="{", capture_output=True, text=True, timeout=600)
    assert done.returncode == 2 and done.stderr.startswith("stiefel: error: stdin: parse error at line 1")


def test_a_name_that_is_neither_file_nor_example_is_told_the_near_one(stiefel):
    result = stiefel("run", "Toutatiss", "--to", 1)
    assert result.status == 2 and "no example has this name; did you mean toutatis?" in result.err
    assert "the examples are discrete_stiefel, " in stiefel("run", "xxxxxxxx", "--to", 1).err


def test_an_epoch_goes_with_the_scene_and_changes_nothing(stiefel, write):
    epoch = write({**TOP, "epoch": "2026-01-01T00:00:00 UTC"}, "epoch.json")
    with_epoch, without = (stiefel("run", scene, "--to", 2).json for scene in (epoch, write(TOP)))
    assert with_epoch["samples"] == without["samples"] and with_epoch["diagnosis"] == without["diagnosis"]
    assert with_epoch["scene"] == {**without["scene"], "epoch": "2026-01-01T00:00:00 UTC"}
    changed = stiefel("run", epoch, "--time", 0.25, "--set", "epoch=2027-01-01").json
    assert changed["scene"]["epoch"] == "2027-01-01"
    result = stiefel("run", write({**TOP, "epoch": 3}), "--to", 2)
    assert result.status == 2 and "epoch: 3: must be a text" in result.err
    result = stiefel("run", write({**TOP, "epoc": "2026"}), "--to", 2)
    assert result.status == 2 and "epoc: unknown field; did you mean epoch?" in result.err


def test_the_transpose_of_a_frame_is_recognised(stiefel, write):
    scene = json.loads((EXAMPLES / "stiefel.json").read_text())
    scene["initial"] = {name: np.transpose(block).tolist() for name, block in scene["initial"].items()}
    result = stiefel("run", write(scene), "--to", 1)
    assert result.status == 2 and "initial.Q: 4 x 2: is the transpose of a frame, whose rows are orthonormal: must be 2 x 4" in result.err
