"""The command `stiefel`: what it writes, and what it tells the shell."""
import csv
import io
import json
import os
import pathlib
import re
import socket
import subprocess

import numpy as np
import pytest

from conftest import matrix

EXAMPLES = pathlib.Path(__file__).parents[2] / "client/examples"
SCENES = ["tumbling_spacecraft", "envisat", "rigid_body_8", "moser_veselov"]


def bits(values):
    return np.asarray(values, dtype=float).tobytes()


def steps(result):
    return [sample["step"] for sample in result.json["samples"]]


# What is sampled


@pytest.mark.parametrize("arguments, expected", [
    (["--to", 3], [0, 1, 2, 3]),
    (["--to", 0], [0]),
    (["--to", 11, "--from", 2, "--every", 4], [2, 6, 10, 11]),
    (["--to", 10, "--every", 5], [0, 5, 10]),
    (["--to", 7, "--from", 7], [7]),
    (["--to", 5, "--every", 1000], [0, 5]),
])
def test_samples_from_every_and_always_the_last(stiefel, write, scene, arguments, expected):
    result = stiefel("run", write(scene), *arguments)
    assert result.status == 0
    assert steps(result) == expected


def test_without_every_a_long_run_gives_its_two_ends(stiefel, write, scene):
    path = write(scene)
    assert len(steps(stiefel("run", path, "--to", 999))) == 1000
    assert steps(stiefel("run", path, "--to", 1000)) == [0, 1000]
    assert steps(stiefel("run", path, "--from", 1, "--to", 1000)) == list(range(1, 1001))


def test_the_json_is_the_documented_one(stiefel, write, scene):
    result = stiefel("run", write(scene), "--to", 2, "--fields", "Q,quaternion").json
    assert set(result) == {"outcome", "samples", "diagnosis"}
    assert result["outcome"] == "REACHED"
    sample = result["samples"][2]
    assert set(sample) == {"step", "time", "fields"}
    assert type(sample["step"]) is int and sample["time"] == 0.02
    assert list(sample["fields"]) == ["Q", "quaternion"]
    assert set(sample["fields"]["Q"]) == {"rows", "cols", "values"}
    assert sample["fields"]["quaternion"]["rows"] == 1
    assert sample["fields"]["quaternion"]["cols"] == len(sample["fields"]["quaternion"]["values"]) == 4
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
    assert fields["M"]["values"] == np.ravel(M).tolist()


@pytest.mark.parametrize("name", SCENES)
def test_examples_run_and_keep_what_they_should(stiefel, name):
    result = stiefel("run", EXAMPLES / f"{name}.json", "--to", 2000, "--every", 500)
    assert result.status == 0, result.err
    diagnosis = result.json["diagnosis"]
    exact = all(i["conservation"] == "exact" for i in diagnosis["invariants"])
    assert diagnosis["orthogonality"] < (1e-13 if exact else 1e-9)
    assert all(i["drift"] < (1e-13 if i["conservation"] == "exact" else 1e-9) for i in diagnosis["invariants"])


# Formats


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
    expected = {name: [np.reshape(s["fields"][name]["values"], (s["fields"][name]["rows"], -1))
                       for s in samples] for name in ("Q", "M", "Omega")}
    with np.load(tmp_path / "out.npz") as arrays:
        assert sorted(arrays.files) == ["M", "Omega", "Q", "step", "time"]
        assert arrays["step"].dtype == np.int64
        assert arrays["step"].tolist() == [s["step"] for s in samples]
        assert bits(arrays["time"]) == bits([s["time"] for s in samples])
        for field, values in expected.items():
            assert arrays[field].shape == np.shape(values)
            assert bits(arrays[field]) == bits(values)

    header, *rows = csv.reader(io.StringIO((tmp_path / "out.csv").read_text()))
    assert header[:3] == ["step", "time", "Q[1,1]"]
    n = expected["Q"][0].shape[0]
    assert header[2 + n] == "Q[2,1]" and header[-1] == f"Omega[{n},{n}]"
    assert [int(row[0]) for row in rows] == [s["step"] for s in samples]
    flat = [[s["time"], *(x for f in s["fields"].values() for x in f["values"])] for s in samples]
    assert bits([[float(x) for x in row[1:]] for row in rows]) == bits(flat)


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


# Numerical stops


@pytest.mark.parametrize("extension", ["json", "csv", "npz"])
def test_a_stop_is_status_3_and_the_file_is_written(stiefel, write, too_long, tmp_path, extension):
    result = stiefel("run", write(too_long), "--to", 10, "--output", f"out.{extension}")
    assert result.status == 3
    assert result.err.startswith("stiefel: LEFT_DOMAIN after step 0: ")
    report = json.loads((tmp_path / "out.json").read_text()) if extension == "json" else result.json
    assert report["outcome"] == "LEFT_DOMAIN"
    assert 0 < report["largest_step"] < 5
    assert report["message"]
    assert (tmp_path / f"out.{extension}").exists()


def test_the_largest_step_works_and_a_longer_one_does_not(stiefel, write, too_long):
    largest = stiefel("run", write(too_long), "--to", 1).json["largest_step"]
    assert stiefel("run", write({**too_long, "step": largest}), "--to", 1).status == 0
    assert stiefel("run", write({**too_long, "step": 1.002 * largest}), "--to", 1).status == 3


def test_diagnose_a_stop(stiefel, write, too_long):
    result = stiefel("diagnose", write(too_long), "--to", 10)
    assert result.status == 3
    assert result.json["outcome"] == "LEFT_DOMAIN"
    assert result.json["diagnosis"]["invariants"]


def test_a_stop_says_by_which_angle_the_step_turns(stiefel, write, too_long):
    """By 5 ‖Omega‖, Omega_ij = M_ij / (lambda_i + lambda_j)."""
    for command in ("run", "diagnose"):
        result = stiefel(command, write(too_long), "--to", 10)
        angle = np.degrees(5.0 * np.hypot(3 / 3.0, np.hypot(0.01 / 4.0, 0.001 / 2.0)))
        asked, largest = re.search(r"the step of 5 turns the body by (\d+)° and has no solution on the principal branch; "
                                   r"the largest .* which turns it by ([\d.]+)°", result.json["message"]).groups()
        assert float(asked) == pytest.approx(angle, rel=6e-3)
        assert float(largest) == pytest.approx(result.json["largest_step"] / 5.0 * angle, rel=6e-3)
        assert result.json["message"] in result.err


# Diagnose and describe


@pytest.mark.parametrize("command", ["run", "diagnose"])
def test_moments_of_no_body_are_warned_of(stiefel, write, command):
    body = {"moments": [1, 0.5, 2], "angular_velocity": [0.1, 0.2, 0.3]}
    scene = {"system": "rigid_body", "method": {"name": "exact"}, "step": 0.1, "body": body}
    result = stiefel(command, write(scene), "--to", 2)
    assert result.status == 0
    assert result.err == "warning: I1 + I2 = 1.5 < I3 = 2: no rigid body has these moments\n"
    body["moments"] = [1, 0.5, 1.5]
    assert stiefel(command, write(scene), "--to", 2).err == ""


def test_diagnose_says_what_run_says(stiefel, write, scene):
    path = write(scene)
    diagnosed, run = stiefel("diagnose", path, "--to", 50), stiefel("run", path, "--to", 50)
    assert diagnosed.status == 0
    assert set(diagnosed.json) == {"outcome", "diagnosis"}
    assert diagnosed.json["diagnosis"] == run.json["diagnosis"]


def test_diagnose_only_what_is_named(stiefel, write, scene):
    result = stiefel("diagnose", write(scene), "--to", 50, "--invariants", "energy,casimirs").json
    names = {re.sub(r"\[.*", "", i["name"]) for i in result["diagnosis"]["invariants"]}
    assert names == {"energy", "casimirs"}


def test_momentum_only_has_no_orthogonality(stiefel, write, scene):
    del scene["initial"]["Q"]
    result = stiefel("run", write(scene), "--to", 5).json
    assert list(result["samples"][0]["fields"]) == ["M"]
    assert "orthogonality" not in result["diagnosis"]


def test_describe_lists_what_the_json_lists(stiefel):
    table, description = stiefel("describe"), stiefel("describe", "--json").json
    assert table.status == 0
    assert description["limits"]["max_dimension"] == 512
    for system in description["systems"]:
        assert f"\n{system['name']}" in table.out
        for item in system["fields"] + system["invariants"] + system.get("forms", []):
            assert f" {item['name']} " in table.out
        recommended = [line for line in table.out.split(f"\n{system['name']}")[1].split("\n\n")[0].splitlines()
                       if line.startswith("  recommended")]
        assert len(recommended) == len(system.get("recommended", [])) and bool(recommended) != system["discrete"]
        for line, item in zip(recommended, system.get("recommended", [])):
            assert item["method"]["name"] in line and (item["where"] or "(every scene)") in line
    for method in description["methods"]:
        assert f"\n  {method['name']} " in table.out


# The estimated error


def test_invariants_kept_is_not_attitude_accurate(stiefel, write):
    """Envisat after 6000 s: order 2 is off by more than a degree, order 10 by nothing; both keep everything."""
    scene = json.loads((EXAMPLES / "envisat.json").read_text())
    second = stiefel("run", write({**scene, "method": {"name": "variational"}}), "--to", 6000, "--every",
                     6000).json["diagnosis"]
    error = second["estimated_error"]
    assert error["attitude_degrees"] == pytest.approx(1.2, abs=0.05)
    assert error["attitude"] == pytest.approx(1.59e-2, rel=0.05) and error["momentum"] > 1e-5
    assert max(i["drift"] for i in second["invariants"]) < 1e-13
    assert error["work"] < error["run_work"] and "closed form" in error["reference"]
    assert re.fullmatch(r"invariants kept to \d.\de-1\d; estimated error at t = 6000: "
                        r"attitude 1.\de-02 \(1.2°\), momentum \d.\de-0\d", second["summary"])
    tenth = stiefel("diagnose", write({**scene, "method": {"name": "preprocessed_variational", "order": 10}}), "--to",
                    6000).json["diagnosis"]["estimated_error"]
    assert 1e-14 < tenth["attitude"] < 2e-12


def test_an_estimate_that_costs_more_than_the_run_is_for_those_who_ask(stiefel, write, scene):
    path = write(scene)
    for command in ("run", "diagnose"):
        shy, asked, never = (stiefel(command, path, "--to", 2, *more).json["diagnosis"]
                             for more in ([], ["--error"], ["--no-error"]))
        assert "attitude" not in shy["estimated_error"]
        assert "would take" in shy["estimated_error"]["missing"] and "would take" in shy["summary"]
        assert 0 < asked["estimated_error"]["attitude"] < 1e-3
        assert asked["estimated_error"]["work"] > asked["estimated_error"]["run_work"]
        assert "estimated_error" not in never and never["summary"].endswith("error at t = 0.02 not estimated")
    assert stiefel("run", path, "--to", 2, "--error", "--no-error").status == 2


def test_the_error_of_a_run_that_stopped_is_that_of_its_last_state(stiefel, write, too_long):
    diagnosis = stiefel("diagnose", write(too_long), "--to", 10, "--error").json["diagnosis"]
    assert diagnosis["estimated_error"]["attitude"] < 1e-15 and "at t = 0:" in diagnosis["summary"]


def test_a_discrete_system_has_no_error(stiefel):
    diagnosis = stiefel("diagnose", EXAMPLES / "moser_veselov.json", "--to", 5, "--error").json["diagnosis"]
    assert "discrete system" in diagnosis["estimated_error"]["missing"]


# Bad input


def changed(**changes):
    return lambda scene: {**scene, **changes}


@pytest.mark.parametrize("change, faults", [
    (changed(step=0), ["step: 0"]),
    (changed(step="NaN"), ["step: nan"]),
    (changed(step="soon"), ["step", "soon"]),
    (lambda scene: {name: scene[name] for name in scene if name != "step"},
     ["scene.json: step: absent: must be given, finite and not 0"]),
    (changed(stepp=1), ["scene.json: stepp: unknown field; did you mean step?"]),
    (changed(epsilon=0.5), ["scene.json: epsilon: given: must be absent"]),
    (changed(parameter=0.5), ["scene.json: parameter: given: must be absent"]),
    (changed(horizon=-1), ["scene.json: horizon: -1"]),
    (changed(system="rigidbody"), ["scene.json: system: ", "rigidbody", "did you mean rigid_body?"]),
    (changed(inertia=[1, -1, 0.5]), ["inertia"]),
    (changed(step=0, inertia=[1, "NaN", 1]), ["step: 0", "inertia[1]: nan"]),
    (lambda scene: [scene], ["Root element must be a message"]),
    (lambda scene: json.dumps(scene)[:-1], ["line 1, column"]),
    (lambda scene: json.dumps(scene)[:-1] + ', "step": 2}', ["step: given twice"]),
    (lambda scene: "", ["parse error"]),
    (lambda scene: "\0\1\2", ["parse error"]),
    (lambda scene: "[" * 100_000, ["nested deeper"]),
    (lambda scene: '{"a":' * 100_000, ["a: unknown field"]),
    (lambda scene: '{"initial":' + '{"a":' * 100_000, ["initial.a.a: unknown field"]),
])
def test_a_bad_scene_is_status_2_a_line_a_fault(stiefel, write, scene, change, faults):
    result = stiefel("run", write(change(scene)), "--to", 5)
    assert result.status == 2
    assert result.out == ""
    lines = result.err.splitlines()
    assert all(line.startswith("stiefel: error: ") and "scene.json: " in line for line in lines)
    assert all(fault in result.err for fault in faults)
    assert len(lines) >= len([fault for fault in faults if ": " in fault])


@pytest.mark.parametrize("arguments, fault", [
    ([], "--to is required"),
    (["--to", "x"], "--to"),
    (["--to", 5, "--sideways"], "--sideways"),
    (["--to", -1], "--to: -1"),
    (["--to", 2**62], "--to: "),
    (["--to", 5, "--from", -1], "--from: -1"),
    (["--to", 5, "--from", 6], "--to: 5"),
    (["--to", 5, "--every", 0], "--every: 0"),
    (["--to", 5, "--every", -3], "--every: -3"),
    (["--to", 5, "--fields", "Q,nothing"], "--fields[1]: nothing"),
    (["--to", 5, "--output", "out.txt"], "must end in .json, .csv or .npz"),
    (["--to", 5, "--output", "nowhere/out.json"], "cannot write"),
    (["--to", 5, "--output", "nowhere/out.npz"], "cannot write"),
])
def test_a_bad_argument_is_status_2(stiefel, write, scene, arguments, fault):
    result = stiefel("run", write(scene), *arguments)
    assert result.status == 2
    assert fault in result.err
    assert result.out == ""


@pytest.mark.parametrize("command", [["diagnose", "--to", 1], ["convert", "--to", "velocity"], ["tradeoff"]],
                         ids=lambda command: command[0])
@pytest.mark.parametrize("name", ["epsilon", "parameter", "horizon"])
def test_a_fault_of_the_scene_is_the_scenes_in_every_command(stiefel, write, scene, command, name):
    result = stiefel(command[0], write({**scene, name: -1}), *command[1:])
    assert result.status == 2
    assert f"scene.json: {name}: " in result.err and "--" + name not in result.err


def test_a_fault_of_an_option_is_the_options(stiefel, write, scene):
    result = stiefel("convert", write(scene), "--to", "parametric_rigid_body", "--parameter", "nan")
    assert result.status == 2 and result.err.startswith("stiefel: error: --parameter: nan")
    result = stiefel("convert", write(scene), "--to", "symmetric_rigid_body", "--epsilon", 0)
    assert result.status == 2 and result.err.startswith("stiefel: error: --epsilon: 0: must be finite and not 0")
    result = stiefel("convert", write(scene), "--to", "velocitty")
    assert (result.status, result.err.startswith("stiefel: error: --to: velocitty: ")) == (2, True)
    assert result.err.endswith("did you mean velocity?\n")


@pytest.mark.parametrize("address", ["127.0.0.1:99999", "127.0.0.1:-1", "127.0.0.1", "not a host:1", "unix:"])
def test_what_is_no_address_is_status_2(stiefel, write, scene, address):
    result = stiefel("run", write(scene), "--to", 1, "--server", address)
    assert result.status == 2 and result.err.startswith(f"stiefel: error: cannot reach {address}: ")


@pytest.mark.parametrize("address", ["127.0.0.1:99999", "127.0.0.1:65536", "127.0.0.1:-1", "", "127.0.0.1",
                                     "not a host:0", "unix:" + 108 * "x"])
def test_a_server_listens_on_no_other_address(address):
    server = subprocess.run([os.environ["STIEFEL_SERVER"], f"--listen={address}"], capture_output=True, text=True,
                            timeout=60)
    assert server.returncode != 0 and server.stdout == ""
    assert f"--listen: {address}" in server.stderr


def test_other_bad_input_is_status_2(stiefel, write, scene, tmp_path):
    assert stiefel().status == 2
    assert stiefel("dance").status == 2
    assert stiefel("diagnose", write(scene), "--to", 5, "--invariants", "luck").status == 2
    missing = stiefel("run", "missing.json", "--to", 5)
    assert (missing.status, missing.err) == (2, "stiefel: error: missing.json: No such file or directory\n")
    assert stiefel("run", tmp_path, "--to", 5).status == 2


@pytest.mark.parametrize("arguments, faults", [
    (["runn", "scene.json", "--to", "5"], ["unknown command runn; did you mean run?"]),
    (["Run"], ["unknown command Run; did you mean run?"]),
    (["trade-off", "scene.json"], ["unknown command trade-off; did you mean tradeoff?"]),
    (["diagnos", "scene.json"], ["unknown command diagnos; did you mean diagnose?"]),
    (["dance"], ["unknown command dance; the commands are describe, run, diagnose, convert, tradeoff, connect"]),
    ([], ["a command is required: describe, run, diagnose, convert, tradeoff, connect"]),
    (["run", "scene.json", "--to", "5", "--evry", "2"], ["unknown option --evry; did you mean --every?"]),
    (["run", "scene.json", "--too=5"], ["unknown option --too; did you mean --to?"]),
    (["run", "scene.json", "--to", "5", "--form", "1", "--outptu", "x"],
     ["unknown option --form; did you mean --from?", "unknown option --outptu; did you mean --output?"]),
    (["run", "scene.json", "-to", "5"], ["unknown option -to; did you mean --to?"]),
    (["run", "scene.json", "--to", "5", "--sideways"], ["unknown option --sideways"]),
    (["--versoin"], ["unknown option --versoin; did you mean --version?"]),
    (["run", "scene.json", "other.json", "--to", "5"], ["unexpected argument other.json"]),
    (["run", "--to", "5"], ["SCENE is required"]),
])
def test_a_misspelt_word_is_told_with_its_neighbour(stiefel, arguments, faults):
    result = stiefel(*arguments)
    assert result.status == 2 and result.out == ""
    *lines, hint = result.err.splitlines()
    assert lines == [f"stiefel: error: {fault}" for fault in faults]
    command = arguments[0] + " " if arguments and arguments[0] == "run" else ""
    assert hint == f"See stiefel {command}--help"


def test_a_fault_of_the_scene_is_not_called_an_option(stiefel, write, scene):
    scene["initial"]["P"] = scene["initial"].pop("M")
    result = stiefel("run", write({**scene, "system": "symmetric_rigid_body", "epsilon": 0}), "--to", 5)
    assert result.status == 2
    assert "scene.json: epsilon: 0: must be finite and not 0" in result.err and "--epsilon" not in result.err


def test_a_full_disk_behind_stdout_is_noticed(stiefel):
    with open("/dev/full", "w") as full:
        done = subprocess.run([os.environ["STIEFEL_CLI"], "describe"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert done.stderr == "stiefel: error: cannot write to stdout: No space left on device\n"


def test_help_is_status_0_and_tells_the_statuses(stiefel):
    result = stiefel("--help")
    assert result.status == 0
    assert "Exit status: 0 reached, 2 bad input, 3 numerical stop" in result.out
    for command in ("describe", "run", "diagnose", "convert", "tradeoff", "connect"):
        assert stiefel(command, "--help").status == 0


# Servers


def test_a_server_that_is_not_there_is_status_4(stiefel, write, scene, tmp_path):
    with socket.socket() as silent:  # bound, so that nobody else gets it
        silent.bind(("127.0.0.1", 0))
        for address, reason in [(f"unix:{tmp_path}/none", "there is no such socket"),
                                (f"127.0.0.1:{silent.getsockname()[1]}", "the connection is refused"),
                                ("no-such-host.invalid:50551", "")]:
            result = stiefel("run", write(scene), "--to", 5, "--server", address)
            assert result.status == 4
            assert result.err.startswith(f"stiefel: error: cannot reach {address}: {reason}")
            assert len(result.err.splitlines()) == 1
            assert not re.search("[Aa][Rr][Ee][Ss]|DNS|addresses|UNKNOWN", result.err)


@pytest.mark.parametrize("address, reason", [
    ("localhost:99999", "the port 99999 is not between 1 and 65535"), ("localhost:0", "the port 0 is not between"),
    ("localhost", "the port is missing"), ("localhost:http", "the port 'http' is not a number"),
    ("::1:50551", "[IPv6]:PORT"), ("http://localhost:50551", "without 'http://'"),
])
def test_an_address_that_is_none_is_status_2(stiefel, address, reason):
    result = stiefel("describe", "--server", address)
    assert result.status == 2
    assert result.err.startswith(f"stiefel: error: cannot reach {address}: ") and reason in result.err


def test_another_server_gives_the_same_bytes(stiefel, write, scene, tmp_path):
    address = f"unix:{tmp_path}/server"
    server = subprocess.Popen([os.environ["STIEFEL_SERVER"], "--listen", address])
    try:
        arguments = ["run", write(scene), "--to", 5000, "--every", 50]
        remote = stiefel(*arguments, "--server", address)  # patient while the server starts
        assert remote.status == 0, remote.err
        assert remote.out == stiefel(*arguments).out
        assert stiefel("run", write({**scene, "step": 0}), "--to", 5, "--server", address).status == 2
    finally:
        server.terminate()
        assert server.wait(timeout=30) == 0


# Other variables, two frames, structure


def test_convert_prints_a_scene_that_runs(stiefel, write, scene, tmp_path):
    scene = write(scene)
    done = stiefel("convert", scene, "--to", "symmetric_rigid_body")
    assert done.status == 0 and done.json["scene"]["system"] == "symmetric_rigid_body"
    assert 0 < done.json["margins"]["S_M"] < 2
    alone = stiefel("convert", scene, "--to", "symmetric_rigid_body", "--output", "symmetric.json")
    assert alone.json == {"margins": done.json["margins"]}
    one, other = (stiefel("run", path, "--to", 10, "--every", 10, "--fields", "M").json["samples"][-1]["fields"]["M"]
                  for path in (scene, tmp_path / "symmetric.json"))
    np.testing.assert_allclose(other["values"], one["values"], atol=1e-12)


def test_blocks_are_printed_in_the_order_of_their_names(stiefel, write, scene):
    for target in ["rigid_body", "symmetric_rigid_body", "mclachlan_scovel", "stiefel"]:
        for _ in range(3):
            blocks = list(stiefel("convert", write(scene), "--to", target).json["scene"]["initial"])
            assert blocks == sorted(blocks)


def test_convert_to_velocity(stiefel, write, scene):
    blocks = stiefel("convert", write(scene), "--to", "velocity").json["blocks"]
    assert sorted(blocks) == ["Q", "Qdot"] and len(blocks["Qdot"]["values"]) == 9


def test_convert_outside_a_domain(stiefel, write, scene):
    done = stiefel("convert", write(scene), "--to", "symmetric_rigid_body", "--epsilon", 1)
    assert done.status == 2 and "S_M" in done.err and "the bound is 2" in done.err


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


def test_diagnose_structure(stiefel, write, scene):
    zero = matrix(np.zeros((3, 3)))
    asked = {"forms": [{"form": "omega", "first": {"Q": zero, "M": zero}, "second": {"Q": zero, "M": zero}}]}
    done = stiefel("diagnose", write(scene), "--to", 5, "--symplectic", "--structure", write(asked, "forms.json"))
    assert done.status == 0
    assert done.json["diagnosis"]["forms"] == [0] and done.json["diagnosis"]["symplectic_defect"] < 1e-11
    del asked["forms"][0]["second"]["M"]
    done = stiefel("diagnose", write(scene), "--to", 5, "--structure", write(asked, "forms.json"))
    assert done.status == 2 and "--structure: forms[0].second.M" in done.err
