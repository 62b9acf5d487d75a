"""Scenes, which may be given as a dict, the name of an example, the path of a scene file, or a message."""
from __future__ import annotations

import copy
import json
import os
from pathlib import Path
from typing import Any, Mapping, Optional, Union

import numpy as np
from google.protobuf.message import Message
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.bodies import put_fields
from stiefel._given.examples import examples, near
from stiefel._given.initial import MOMENTA, VELOCITIES, normalized
from stiefel._given.instants import epoch_text
from stiefel._given.mappings import Walk, as_block
from stiefel._given.numbers import Ensemble, block_of, refused
from stiefel._given.shapes import FIELDS, LISTS, count_of, described, owner_of
from stiefel._given.shown import shown
from stiefel._given.typed import Scene
from stiefel._wire.arrays import blocks_of, matrix, put_block
from stiefel.errors import InvalidArgument

SceneLike = Union[Scene, str, "os.PathLike[str]", pb.Scene]


def to_message(scene: SceneLike) -> pb.Scene:
    """Returns the message of a scene. For a type checker a dict is a `stiefel.Scene`, so that it finds a misspelt key.

    In a dict, matrices may be numpy arrays and numbers numpy scalars; times may be timedeltas; numbers with a unit may be
    quantities. `method` may be a name alone. In an ensemble, blocks may be (members, n, N), and lists of which each member has its
    own (members, numbers). In `initial`, Omega may stand instead of the momentum of a body in N dimensions, and Qdot instead of
    S, P or M; the client replaces them when it knows the server. `body` takes what `stiefel.body_scene` takes: an inertia tensor as a
    symmetric 3 x 3 matrix, a Solid or a list of solids; `attitude` as a rotation matrix, a Rotation of scipy or a quaternion in
    the `order` "xyzw", or `mrp` or `euler_angles` instead; `angular_velocity` or `angular_momentum` in the axes `frame`, or
    `euler_rates`. `normalize`: True makes an initial state that was rounded to a few digits fit, and a quaternion of any norm.
    `epoch`: the instant of time 0, which no message has.

    Raises InvalidArgument that names every unknown key and every wrong number, unit, shape and type.
    """
    return with_epoch(scene)[0]


def with_epoch(scene: SceneLike) -> tuple[pb.Scene, Optional[str]]:
    """Returns the message of a scene as `to_message` does, and the scene's epoch as a text with its scale, such as
    "1992-11-09T17:49:47 UTC"; None if it has none."""
    if isinstance(scene, pb.Scene):
        return scene, None
    given = scene if isinstance(scene, Mapping) else read(scene)
    if isinstance(scene, str) and scene in examples and "system" not in given:
        raise refused("scene", f"{scene!r}: is no scene but the arguments of Client.geodesics: {', '.join(given)}")
    walk = Walk(given.get("members"))
    message = walk.read(given, pb.Scene(), "scene")
    epoch, normalize = walk.beside.pop("epoch", None), walk.beside.pop("normalize", False)
    if walk.beside:
        put_fields(message.body, walk.beside, "scene.body.", normalize)
    elif normalize:
        message = normalized(message)
    return message, None if epoch is None else epoch_text(epoch)


def with_changes(scene: pb.Scene, body: Optional[Mapping[str, Any]], initial: Optional[Mapping[str, Any]],
                 normalize: bool = False) -> pb.Scene:
    """Returns a copy of a resolved scene with other fields of `body` and other blocks of `initial`, in the forms that a scene
    takes."""
    changed = copy.deepcopy(scene)
    walk = Walk(scene.members or None)
    if body is not None:
        _change_body(changed.body, body, walk, normalize)
    if initial is not None:
        if scene.HasField("body"):
            raise refused("initial", "the scene has `body`: give fields of `body`")
        _change_blocks(changed, initial, walk.ensemble)
    return normalized(changed) if normalize else changed


def _change_body(body: pb.Body, given: Mapping[str, Any], walk: Walk, normalize: bool) -> None:
    """What `given` says in a form that no message has, such as an angular velocity in space axes, holds for the body with
    everything else that is given."""
    before = {field.name: np.array(value) for field, value in body.ListFields()}
    if not before:
        raise refused("body", "the scene has no `body`: give blocks of `initial`")
    before = {name: values if values.size == count_of(f"body.{name}") else values.reshape(walk.ensemble.members or 1, -1)
              for name, values in before.items()}
    walk.read(given, pb.Body(), "body")
    body.Clear()
    put_fields(body, walk.beside, "body.", normalize, before)


def _change_blocks(scene: pb.Scene, given: Mapping[str, Any], ensemble: Ensemble) -> None:
    before = blocks_of(scene)
    moves = {*MOMENTA} & {*before}
    known = {*before, *(("M", *VELOCITIES) if moves else ())}
    for name in given:
        if name not in known:
            raise refused(f"initial.{name}", f"unknown block; the blocks are {', '.join(sorted(before))}")
    if {*MOMENTA, *VELOCITIES} & {*given}:
        for name in moves:
            scene.initial.pop(name, None)
            scene.initial_tensors.pop(name, None)
    for name, block in given.items():
        put_block(scene, name, block_of(f"initial.{name}", block, ensemble))


def member_of(scene: pb.Scene, member: int) -> pb.Scene:
    """Returns the scene of one member of an ensemble."""
    alone, members = copy.deepcopy(scene), scene.members
    alone.ClearField("members")
    ensemble = Ensemble()
    for name, block in blocks_of(scene).items():
        own = block.reshape(members, -1, block.shape[-1])[member]
        put_block(alone, name, own)
        ensemble.see(own)
    for path in LISTS:
        message, name = owner_of(alone, path)
        numbers, each = getattr(message, name), ensemble.each(described(FIELDS[path]).count)
        if each and len(numbers) == members * each:
            numbers[:] = numbers[member * each:(member + 1) * each]
    return alone


def to_method(method: Union[Mapping[str, Any], str]) -> pb.Method:
    """Returns the message of a scene's `method`, a mapping or the name alone."""
    return Walk().read(method, pb.Method(), "method")


def read(file: "str | os.PathLike[str]") -> Mapping[str, Any]:
    """Reads the example of this name or a file in JSON. Raises OSError if that fails, and InvalidArgument if the file holds
    no JSON object."""
    if not isinstance(file, (str, os.PathLike)):
        raise refused("scene", f"{shown(file)}: must be a dict, the name of an example, the path of a scene file or a "
                               "Scene message")
    if isinstance(file, str) and file in examples:
        return dict(examples[file])
    try:
        text = Path(file).read_bytes()
    except FileNotFoundError as error:
        if isinstance(file, str) and file.isidentifier():
            error.strerror = f"{error.strerror}, and no example has this name{near(file)}"
        raise
    return parse_json(os.fspath(file), text)


def parse_json(file: str, text: bytes) -> dict[str, Any]:
    """Reads the text of a file, with or without a byte order mark. Raises InvalidArgument as `read` does."""
    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        names = [name for name, _ in pairs]
        twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
        if twice is not None:
            raise refused("scene", f"{file}: {twice}: given twice")
        return dict(pairs)

    saved = "; stiefel.load and stiefel.rerun read a file of samples" * (Path(file).suffix in (".csv", ".npz"))
    try:
        found = json.loads(text.decode("utf-8-sig"), object_pairs_hook=once)
    except InvalidArgument:
        raise
    except UnicodeDecodeError as error:
        raise refused("scene", f"{file}: byte {error.start}: must be UTF-8{saved}") from None
    except (ValueError, RecursionError) as error:
        raise refused("scene", f"{file}: not JSON: {error}{saved}") from None
    if not isinstance(found, dict):
        raise refused("scene", f"{file}: {shown(found)}: must be an object: {{...}}")
    return found


def to_dict(scene: SceneLike) -> dict[str, Any]:
    """Returns the JSON form of a scene as a dict: the proto's field names, blocks as nested lists, and its epoch if it has
    one. A complex block is a dict of two nested lists, `values` and `imaginary`."""
    message, epoch = with_epoch(scene)
    description = {field.name: _plain(value) for field, value in message.ListFields() if not field.name.startswith("initial")}
    if (blocks := blocks_of(message)):
        description["initial"] = {name: _lists(block.reshape(-1, block.shape[-1])) for name, block in blocks.items()}
    return description if epoch is None else {**description, "epoch": epoch}


def _plain(value: Any) -> Any:
    if isinstance(value, Message):
        return {field.name: _plain(part) for field, part in value.ListFields()}
    return value if isinstance(value, (str, int, float)) else list(value)


def _lists(block: NDArray[Any]) -> Any:
    if not np.iscomplexobj(block):
        return block.tolist()
    return {"values": np.real(block).tolist(), "imaginary": np.imag(block).tolist()}


def to_matrix(block: Any, path: str = "matrix") -> pb.Matrix:
    """Returns the message of an array, nested list or mapping. `path` is its name in errors."""
    given = as_block(path, block)
    return Walk().read(given, pb.Matrix(), path) if isinstance(given, Mapping) else matrix(given)
