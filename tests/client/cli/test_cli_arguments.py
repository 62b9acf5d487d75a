"""Command lines that the command refuses: status 2, and each line names the option or the misspelt word."""
import pytest


@pytest.mark.parametrize("arguments, fault", [
    ([], "--to is required"),
    (["--to", "x"], "--to: x: must be a whole number"),
    (["--to", 100.5], "--to: 100.5: must be a whole number: it counts steps; stiefel run --times FILE gives samples between them"),
    (["--to", "1e300"], "--to: 1e300: must be a whole number"),
    (["--to", "nan"], "--to: nan: must be a whole number"),
    (["--to", 5, "--every", 0.5], "--every: 0.5: must be a whole number"),
    (["--to", 5, "--sideways"], "--sideways"),
    (["--to", -1], "--to: -1: must be 0 to 9007199254740992; for times before 0, use a negative step in the scene"),
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


def test_an_unknown_variable_is_warned_of(stiefel, monkeypatch):
    for name, value in {"STIEFEL_TOKN": "t", "STIEFEL_COLOUR": "red", "STIEFEL_SERVICE_HOST": "10.0.0.1",
                        "STIEFEL_PORT": "tcp://10.0.0.1:50551", "STIEFEL_THREADS": "2"}.items():
        monkeypatch.setenv(name, value)
    assert stiefel("describe").err.splitlines() == [
        "warning: STIEFEL_COLOUR: unknown variable",
        "warning: STIEFEL_TOKN: unknown variable; did you mean STIEFEL_TOKEN?"]


@pytest.mark.parametrize("arguments, near", [
    (["run", "scene.json", "--to", 5, "--evry", 2], "--evry; did you mean --every?"),
    (["describe", "--jsn"], "--jsn; did you mean --json?"), (["--versoin"], "--versoin; did you mean --version?"),
])
def test_an_unknown_option_is_status_2(stiefel, arguments, near):
    told = stiefel(*arguments)
    assert told.status == 2 and told.err.startswith(f"stiefel: error: unknown option {near}\nSee stiefel ")


@pytest.mark.parametrize("thirty", ["30", "30.0", "3e1", "+30", "0.3e2"])
def test_a_whole_number_may_have_any_form(stiefel, write, scene, thirty):
    path = write(scene)
    expected = stiefel("run", path, "--to", 30, "--every", 30, "--from", 0)
    assert stiefel("run", path, "--to", thirty, "--every", thirty, "--from", "0.0").out == expected.out
    assert stiefel("diagnose", path, "--to", thirty).status == 0
    statistics = stiefel("summarize", path, "--to", thirty, "--every", thirty, "--quantity", "energy=last")
    assert statistics.status == 0 and statistics.json["last_step"] == 30


def test_a_fault_of_an_option_is_the_options(stiefel, write, scene):
    result = stiefel("convert", write(scene), "--to", "parametric_rigid_body", "--parameter", "nan")
    assert result.status == 2 and result.err.startswith("stiefel: error: --parameter: nan")
    result = stiefel("convert", write(scene), "--to", "symmetric_rigid_body", "--epsilon", 0)
    assert result.status == 2 and result.err.startswith("stiefel: error: --epsilon: 0: must be finite and not 0")
    result = stiefel("convert", write(scene), "--to", "velocitty")
    assert (result.status, result.err.startswith("stiefel: error: --to: velocitty: ")) == (2, True)
    assert result.err.endswith("did you mean velocity?\n")


def test_other_bad_input_is_status_2(stiefel, write, scene, tmp_path):
    assert stiefel().status == 2
    assert stiefel("dance").status == 2
    assert stiefel("diagnose", write(scene), "--to", 5, "--invariants", "luck").status == 2
    missing = stiefel("run", "missing.json", "--to", 5)
    assert (missing.status, missing.err) == (2, "stiefel: error: missing.json: No such file or directory\n")
    assert stiefel("run", tmp_path, "--to", 5).status == 2


COMMANDS = "conjugate-points, connect, convert, describe, diagnose, linearize, lyapunov, poincare, report, rerun, run, summarize, tradeoff"


@pytest.mark.parametrize("arguments, faults", [
    (["runn", "scene.json", "--to", "5"], ["unknown command runn; did you mean run?"]),
    (["Run"], ["unknown command Run; did you mean run?"]),
    (["trade-off", "scene.json"], ["unknown command trade-off; did you mean tradeoff?"]),
    (["diagnos", "scene.json"], ["unknown command diagnos; did you mean diagnose?"]),
    (["dance"], [f"unknown command dance; the commands are {COMMANDS}"]),
    ([], [f"a command is required: {COMMANDS}"]),
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
