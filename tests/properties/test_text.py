"""A scene that is printed and read again is the same scene."""
import json

from hypothesis import given, settings, strategies as st

import scenes
from stiefel.cli import main
from stiefel._scene import to_dict, to_message

finite = st.floats(allow_nan=False, allow_infinity=False)


@given(data=st.data())
def test_printed_and_read_in_python(client, pair, data):
    scene = to_message(data.draw(scenes.scenes(pair)))
    assert to_message(json.loads(json.dumps(to_dict(scene)))) == scene
    with client.create(scene) as session:
        assert to_message(json.loads(json.dumps(session.scene))) == session._resolved()


@given(numbers=st.lists(finite, min_size=9, max_size=9), step=finite)
def test_every_double_survives(numbers, step):
    scene = to_message({"system": "rigid_body", "inertia": numbers[:3], "step": step,
                        "initial": {"Q": {"rows": 3, "cols": 3, "values": numbers}}})
    assert to_message(json.loads(json.dumps(to_dict(scene)))) == scene


@settings(max_examples=max(5, settings.default.max_examples // 2))
@given(scene=scenes.any_scenes())
def test_printed_and_read_by_the_command(client, tmp_path_factory, scene):
    """`convert` to the scene's own system prints the resolved scene, which stays the same when it is converted
    again."""
    folder = tmp_path_factory.mktemp("scenes")
    (folder / "0.json").write_text(json.dumps(to_dict(scene)))
    for k in range(2):
        assert main(["convert", f"{folder}/{k}.json", "--system", scene["system"], "--output", f"{folder}/{k + 1}.json",
                     "--server", client.address]) == 0
    assert (folder / "1.json").read_text() == (folder / "2.json").read_text()
