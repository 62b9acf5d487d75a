"""Scenes that the command refuses: status 2, a line a fault, and each line names file, field and rule."""
import json

import pytest


def changed(**changes):
    return lambda scene: {**scene, **changes}


@pytest.mark.parametrize("change, faults", [
    (changed(step=0), ["step: 0"]),
    (changed(step="NaN"), ["step: nan"]),
    (changed(step="soon"), ['scene.json: step: "soon": must be a number']),
    (changed(inertia=[1, [2, 3], 1]), ["scene.json: inertia: must be rows of one length"]),
    (changed(members=2.5), ["scene.json: members: 2.5: must be a whole number of at least 0"]),
    (changed(initial=3), ["scene.json: initial: 3: must be an object of names and values"]),
    (lambda scene: {name: scene[name] for name in scene if name != "step"},
     ["scene.json: step: absent: must be given, finite and not 0"]),
    (changed(stepp=1), ["scene.json: stepp: unknown field; did you mean step?"]),
    (changed(epsilon=0.5), ["scene.json: epsilon: given: must be absent"]),
    (changed(parameter=0.5), ["scene.json: parameter: given: must be absent"]),
    (changed(horizon=-1), ["scene.json: horizon: -1"]),
    (changed(system=""), ["scene.json: system: absent: must be one of rigid_body, "]),
    (changed(system="rigidbody"), ["scene.json: system: ", "rigidbody", "did you mean rigid_body?"]),
    (changed(inertia=[1, -1, 0.5]), ["inertia"]),
    (changed(step=0, inertia=[1, "NaN", 1]), ["step: 0", "inertia[1]: nan"]),
    (lambda scene: [scene], ["scene.json: a list: must be an object"]),
    (lambda scene: "17", ["scene.json: 17: must be an object"]),
    (lambda scene: json.dumps(scene)[:-1], ["line 1, column"]),
    (lambda scene: json.dumps(scene)[:-1] + ', "step": 2}', ["step: given twice"]),
    (lambda scene: "", ["parse error"]),
    (lambda scene: "\0\1\2", ["parse error"]),
    (lambda scene: "[" * 100_000, ["must be an object"]),
    (lambda scene: '{"inertia":' + "[" * 100_000, ["inertia[0][0][0]: a list: must be a number"]),
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


@pytest.mark.parametrize("command", [["diagnose", "--to", 1], ["convert", "--to", "velocity"], ["tradeoff"]],
                         ids=lambda command: command[0])
@pytest.mark.parametrize("name", ["epsilon", "parameter", "horizon"])
def test_a_fault_of_the_scene_is_the_scenes_in_every_command(stiefel, write, scene, command, name):
    result = stiefel(command[0], write({**scene, name: -1}), *command[1:])
    assert result.status == 2
    assert f"scene.json: {name}: " in result.err and "--" + name not in result.err


def test_a_fault_of_the_scene_is_not_called_an_option(stiefel, write, scene):
    scene["initial"]["P"] = scene["initial"].pop("M")
    result = stiefel("run", write({**scene, "system": "symmetric_rigid_body", "epsilon": 0}), "--to", 5)
    assert result.status == 2
    assert "scene.json: epsilon: 0: must be finite and not 0" in result.err and "--epsilon" not in result.err


def test_a_byte_order_mark_is_no_fault(stiefel, write, scene, tmp_path):
    marked = stiefel("run", write("\ufeff" + json.dumps(scene)), "--to", 2)
    assert marked.status == 0 and marked.out == stiefel("run", write(scene, "plain.json"), "--to", 2).out
    (tmp_path / "times.txt").write_text("\ufeff0.01 0.015", encoding="utf-8")
    assert stiefel("run", write(scene), "--times", tmp_path / "times.txt").status == 0
    (tmp_path / "wide.json").write_text(json.dumps(scene), encoding="utf-16")
    wide = stiefel("run", tmp_path / "wide.json", "--to", 2)
    assert wide.status == 2 and "wide.json: is UTF-16: must be UTF-8" in wide.err
