"""Scenes, which may be given as a dict, the name of an example, the path of a scene file, or a message."""
from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any, Mapping, Optional, Union

import numpy as np
from google.protobuf.message import Message
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.bodies import FORMS, has_forms, with_fields
from stiefel._given.examples import examples, near
from stiefel._given.instants import epoch_text
from stiefel._given.mappings import parse
from stiefel._given.normalized import normalized
from stiefel._given.numbers import number, refused
from stiefel._given.shown import shown
from stiefel._given.typed import Scene
from stiefel._given.shapes import LISTS, NUMBERS, Ensemble, block_of, count_of, list_of, owner_of, unit_of
from stiefel._given.velocities import MOMENTA, with_momenta
from stiefel._wire.arrays import decode, matrix, put_block, to_array
from stiefel.errors import InvalidArgument, Violation

__all__ = ["SceneLike", "to_dict", "to_message"]

#: The fields of a body of which a field or a form takes the place.
_INSTEAD = {"moments": ("inertia_tensor",), "inertia_tensor": ("moments",), "mrp": ("attitude",),
            "angular_momentum": ("angular_velocity",)}

SceneLike = Union[Scene, str, "os.PathLike[str]", pb.Scene]


def to_message(scene: SceneLike) -> pb.Scene:
    """Returns the message of a scene. For a type checker a dict is a `stiefel.Scene`, so that it finds a misspelt key.

    In a dict, matrices may be numpy arrays and numbers numpy scalars; times may be timedeltas; times, moments and
    angular velocities may be quantities with units. An inertia tensor may be a symmetric 3 x 3 matrix, a Solid or a list of
    solids. In an ensemble, blocks may be (members, n, N), and lists of which each member has its own (members, numbers). In `initial`,
    Omega may stand instead of the momentum of a body in N dimensions, and Qdot instead of S, P or M. In `body`, `attitude`
    may be a rotation matrix, a Rotation of scipy or a quaternion in the `order` "xyzw", or `mrp` may stand instead, and
    `angular_velocity` or `angular_momentum` may be in the axes `frame`, as in `stiefel.body`. `normalize`: True makes an
    initial state that was rounded to a few digits fit, and a quaternion of any norm. `method` may be a name alone. Raises InvalidArgument that names the first wrong number, unit or
    shape, or the paths of all unknown keys and values of a wrong type.

    A dict or a file may also have an `epoch`, the instant of time 0, which no message has.
    """
    return with_epoch(scene)[0]


def with_epoch(scene: SceneLike) -> tuple[pb.Scene, Optional[str]]:
    """Returns the message of a scene as `to_message` does, and the scene's epoch as a text with its scale, such as
    "1992-11-09T17:49:47 UTC"; None if it has none."""
    if isinstance(scene, pb.Scene):
        return scene, None
    description = _by_name(scene if isinstance(scene, Mapping) else _read_scene(scene), pb.Scene)
    epoch, normalize = description.pop("epoch", None), description.pop("normalize", None)
    if not isinstance(normalize, (bool, type(None))):
        raise refused("scene.normalize", f"{shown(normalize)}: must be true or false")
    message = _message(description, bool(normalize))
    return normalized(message) if normalize else message, None if epoch is None else epoch_text(epoch)


def with_given_names(error: InvalidArgument, scene: SceneLike) -> InvalidArgument:
    """Returns the error of a scene, which names Omega or Qdot where the scene has it instead of the block of the system."""
    description = scene if isinstance(scene, Mapping) else {} if isinstance(scene, pb.Scene) else _read_scene(scene)
    initial: Any = description.get("initial")
    given = next((name for name in ("Omega", "Qdot") if isinstance(initial, Mapping) and name in initial), None)
    if given is None or error.violations is None:
        return error
    told = tuple(Violation(f"scene.initial.{given}" if one.field in (f"scene.initial.{name}" for name in "MSP") else one.field,
                           one.description) for one in error.violations)
    if told and told != error.violations:
        error._say("; ".join(f"{one.field}: {one.description}" for one in told))
        error.violations = told
    return error


def _message(description: dict[str, Any], normalize: bool) -> pb.Scene:
    ensemble, arrays = Ensemble.of(description.get("members")), {}
    if isinstance(description.get("initial"), Mapping):
        blocks: Mapping[str, Any] = {
            name: _block(f"scene.initial.{name}", block, ensemble) for name, block in description["initial"].items()}
        ensemble = ensemble.with_blocks(blocks.values())
        blocks = with_momenta(description.get("system"), blocks, description.get("inertia"))
        arrays = {name: block for name, block in blocks.items() if not isinstance(block, Mapping)}
        description["initial"] = {name: block for name, block in blocks.items() if name not in arrays}
    if isinstance(description.get("method"), str):
        description["method"] = {"name": description["method"]}
    body = description.get("body")
    if isinstance(body, Mapping) and isinstance(body.get("body"), Mapping):
        raise refused("scene.body", "is a whole scene, as stiefel.body returns it: give it in place of the scene, "
                      "{**stiefel.body(...), ...}")
    if isinstance(body, Mapping) and has_forms(body):
        description["body"] = with_fields(_by_name(body, pb.Body), "scene.body.", normalize, ensemble.members)
    message = pb.Scene()
    for name, kind in (("body", pb.Body), ("method", pb.Method)):
        if isinstance(description.get(name), Mapping):
            description[name] = _without_lists(f"{name}.", _by_name(description[name], kind), ensemble, getattr(message, name))
    parse(_in_json(_plain(_without_lists("", description, ensemble, message))), message, "scene")
    for name, block in arrays.items():
        put_block(message, name, block)
    return message


def with_changes(scene: pb.Scene, body: Optional[Mapping[str, Any]], initial: Optional[Mapping[str, Any]],
                 normalize: bool = False) -> pb.Scene:
    """Returns a copy of a resolved scene with other fields of `body` and other blocks of `initial`, in the forms that a scene
    takes."""
    changed = pb.Scene()
    changed.CopyFrom(scene)
    ensemble = Ensemble.of(scene.members if scene.HasField("members") else None)
    if body is not None:
        _change_body(changed.body, body, ensemble, normalize)
    if initial is not None:
        if scene.HasField("body"):
            raise refused("initial", "the scene has `body`: give fields of `body`")
        _change_blocks(changed, initial, ensemble)
    return normalized(changed) if normalize else changed


def _change_body(body: pb.Body, given: Mapping[str, Any], ensemble: Ensemble, normalize: bool) -> None:
    """What `given` says in a form that no message has, such as an angular velocity in space axes, holds for the body with
    everything else that is given."""
    before = {field.name: np.array(value) for field, value in body.ListFields()}
    if not before:
        raise refused("body", "the scene has no `body`: give blocks of `initial`")
    fields = _by_name(given, pb.Body)
    for name, of in (("order", ("attitude",)), ("frame", ("angular_velocity", "angular_momentum"))):
        if name in fields and not {*of} & {*fields}:
            raise refused(f"body.{name}", f"must be absent where {' or '.join(of)} is not given")
    if has_forms(fields):
        gone = {other for name in fields for other in _INSTEAD.get(name, ())}
        kept = {name: values if values.size == count_of(f"body.{name}") else values.reshape(ensemble.members or 1, -1)
                for name, values in before.items() if name not in gone}
        written = with_fields({**kept, **fields}, "body.", normalize, ensemble.members)
        changed = {*fields, *(other for name in FORMS if name in fields for other in _INSTEAD.get(name, ()))}
        fields = {name: value for name, value in written.items() if name in changed}
    message = pb.Body()
    parse(_in_json(_plain(_without_lists("body.", fields, ensemble, message))), message, "body")
    for field, value in message.ListFields():
        for name in (field.name, *_INSTEAD.get(field.name, ())):
            body.ClearField(name)
        getattr(body, field.name).extend(value)


def _change_blocks(scene: pb.Scene, given: Mapping[str, Any], ensemble: Ensemble) -> None:
    def of_members(block: NDArray[Any]) -> NDArray[Any]:
        fits = ensemble.members is not None and block.ndim == 2 and len(block) % ensemble.members == 0
        return block.reshape(ensemble.members or 1, -1, block.shape[-1]) if fits else block

    before = {name: of_members(block) for name, block in blocks_of(scene).items()}
    moves, any_block = {*MOMENTA} & {*before}, next(iter(before.values()))
    square = (*any_block.shape[:-2], any_block.shape[-1], any_block.shape[-1])
    known = {*before, *(("M", "Omega", "Qdot") if moves else ())}
    for name in given:
        if name not in known:
            raise refused(f"initial.{name}", f"unknown block; the blocks are {', '.join(sorted(before))}")
    blocks = {name: of_members(block_of(f"initial.{name}", block, ensemble)) for name, block in given.items()}
    for name, block in blocks.items():
        like: Any = before.get("Q" if name == "Qdot" else name)
        shape = block.shape if like is None and name == "Qdot" else square if like is None else like.shape
        if block.shape != shape:
            raise refused(f"initial.{name}", f"the shape {block.shape}: must be {shape}")
    gone = moves if {*MOMENTA, "Omega", "Qdot"} & {*blocks} else set()
    inertia = np.reshape(scene.inertia, (-1, any_block.shape[-1])) if scene.inertia else None
    changed = with_momenta(scene.system, {**{name: block for name, block in before.items() if name not in gone}, **blocks},
                           inertia[0] if inertia is not None and len(inertia) == 1 else inertia)
    scene.ClearField("initial")
    scene.ClearField("initial_tensors")
    for name, block in changed.items():
        put_block(scene, name, block)


def member_of(scene: pb.Scene, member: int) -> pb.Scene:
    """Returns the scene of one member of an ensemble."""
    alone, members = pb.Scene(), scene.members
    alone.CopyFrom(scene)
    alone.ClearField("members")
    own = {name: block.reshape(members, -1, block.shape[-1])[member] for name, block in blocks_of(scene).items()}
    for name, block in own.items():
        put_block(alone, name, block)
    ensemble = Ensemble().with_blocks(own.values())
    for path in LISTS:
        message, name = owner_of(alone, path)
        numbers, each = getattr(message, name), ensemble.each(path)
        if each and len(numbers) == members * each:
            numbers[:] = numbers[member * each:(member + 1) * each]
    return alone


def _by_name(mapping: Mapping[str, Any], kind: Any) -> dict[str, Any]:
    """Returns the mapping with the proto's field names in place of lowerCamelCase names, which protobuf reads too."""
    names = {field.json_name: field.name for field in kind.DESCRIPTOR.fields}
    return {names.get(key, key): value for key, value in mapping.items()}


def _without_lists(owner: str, part: dict[str, Any], ensemble: Ensemble, message: Any) -> dict[str, Any]:
    """Returns a part of a scene without its lists of numbers, which `message` gets, because JSON takes 4 us a number. Single
    numbers have no units. `owner`: the part's path."""
    rest = {}
    for name, value in part.items():
        path = f"{owner}{name}"
        if path in LISTS and value is not None:
            getattr(message, name).extend(list_of(path, value, ensemble))
        elif path in NUMBERS and not isinstance(value, (str, type(None))):  # a text may be "NaN" in JSON
            rest[name] = number(f"scene.{path}", value, unit_of(path))
        else:
            rest[name] = value
    return rest


def to_method(method: Union[Mapping[str, Any], str]) -> pb.Method:
    """Returns the message of a scene's `method`, a mapping or the name alone."""
    message = pb.Method()
    if isinstance(method, str):
        method = {"name": method}
    tolerance = method.get("tolerance") if isinstance(method, Mapping) else None
    if tolerance is not None:
        method = {**method, "tolerance": number("method.tolerance", tolerance)}
    parse(_in_json(_plain(method)), message, "method")
    return message


def _read_scene(file: "str | os.PathLike[str]") -> Mapping[str, Any]:
    if isinstance(file, str) and file in examples and "system" not in (example := examples[file]):
        raise refused("scene", f"{file!r}: is no scene but the arguments of Client.geodesic: {', '.join(example)}")
    return read(file)


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
    description: dict[str, Any] = {}
    for field, value in message.ListFields():
        if field.name in ("initial", "initial_tensors"):
            description["initial"] = {name: _lists(block) for name, block in blocks_of(message).items()}
        else:
            description[field.name] = _json_of(value)
    return description if epoch is None else {**description, "epoch": epoch}


def _json_of(value: Any) -> Any:
    """Returns what protobuf's MessageToDict makes of a field of a scene, which takes 1 us for each number of a list."""
    if isinstance(value, Message):
        return {field.name: _json_of(part) for field, part in value.ListFields()}
    if isinstance(value, (str, int, float)):
        return _in_json(value)
    numbers = list(value)
    return numbers if np.isfinite(numbers).all() else _in_json(numbers)


def blocks_of(scene: pb.Scene) -> dict[str, NDArray[Any]]:
    """Returns the blocks of the initial state, (rows, cols) or, where they are given so, (members, rows, cols)."""
    return {**{name: to_array(block) for name, block in sorted(scene.initial.items())},
            **{name: decode(tensor) for name, tensor in sorted(scene.initial_tensors.items())}}


def _lists(block: NDArray[Any]) -> Any:
    if not np.iscomplexobj(block):
        return block.tolist()
    return {"values": np.real(block).tolist(), "imaginary": np.imag(block).tolist()}


def to_matrix(block: Any, path: str = "matrix") -> pb.Matrix:
    """Returns the message of an array, nested list or mapping. `path` is its name in errors."""
    given = _block(path, block)
    if not isinstance(given, Mapping):
        return matrix(given)
    message = pb.Matrix()
    parse(_in_json(_plain(given)), message, path)
    return message


def _block(path: str, block: Any, ensemble: Ensemble = Ensemble()) -> Any:
    """Returns a block as an array, or the mapping of a Matrix with its rows and cols."""
    if not isinstance(block, Mapping):
        return block_of(path, block, ensemble)
    if not isinstance(block.get("values"), (list, tuple)) or not block["values"] or not isinstance(block["values"][0], (list, tuple)):
        return block
    if (unknown := sorted({*block} - {"values", "imaginary"})):
        raise refused(f"{path}.{unknown[0]}", "must be absent where values are nested lists")
    parts = [block_of(f"{path}.{name}", block[name], ensemble) for name in ("values", "imaginary") if name in block]
    if len(parts) == 2 and parts[0].shape != parts[1].shape:
        raise refused(f"{path}.imaginary", f"the shape {parts[1].shape}: must be that of values, {parts[0].shape}")
    return parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def _in_json(value: Any) -> Any:
    """Replaces NaN and the infinities by protobuf's JSON names for them, so that the server reports them."""
    if isinstance(value, Mapping):
        return {key: _in_json(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_in_json(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
