"""Converts scenes, which may be given as a dict, the path of a scene file, or a message."""
from __future__ import annotations

import json
import math
import os
import reprlib
from pathlib import Path
from typing import Any, Mapping, Union

import numpy as np
from google.protobuf import json_format
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel.errors import InvalidArgument, Violation
from stiefel.mappings import parse

_LISTS = {"inertia", "inertia_u", "inertia_v", "inertia_tensor", "moments", "attitude",
          "angular_velocity"}
LARGE = 4096  # numbers; a larger array travels as bytes

SceneLike = Union[Mapping[str, Any], str, "os.PathLike[str]", pb.Scene]


def to_message(scene: SceneLike) -> pb.Scene:
    """Returns the message of a scene.

    In a dict, matrices may be numpy arrays and numbers numpy scalars. In an ensemble, blocks may be (members, n, N),
    and lists of which each member has its own (members, ...). Raises InvalidArgument that names the path of every
    unknown key and every value of a wrong type.
    """
    if isinstance(scene, pb.Scene):
        return scene
    if not isinstance(scene, Mapping):
        scene = _read(scene)
    tensors = {}
    if isinstance(scene.get("initial"), Mapping):
        tensors = {name: block for name, block in scene["initial"].items() if _is_large(block)}
        small = {name: block for name, block in scene["initial"].items() if name not in tensors}
        scene = {**scene, "initial": {name: _matrix(_plain(block), f"scene.initial.{name}")
                                      for name, block in small.items()}}
    description = _plain(scene)
    for path, part in (("scene", description), ("scene.body", description.get("body"))):
        if isinstance(part, dict):
            part.update((name, _ravel(part[name], f"{path}.{name}")) for name in _LISTS & part.keys())
    message = pb.Scene()
    parse(_in_json(description), message, "scene")
    for name, block in tensors.items():
        set_tensor(message.initial_tensors[name], block)
    return message


def to_method(method: Mapping[str, Any]) -> pb.Method:
    """Returns the message of a scene's `method`."""
    message = pb.Method()
    parse(_in_json(_plain(method)), message, "method")
    return message


def _read(file: "str | os.PathLike[str]") -> Mapping[str, Any]:
    """Reads a scene file. Raises OSError if that fails, and InvalidArgument if it holds no JSON object."""
    if not isinstance(file, (str, os.PathLike)):
        raise _wrong("scene", file, "must be a dict, the path of a scene file or a Scene message")
    try:
        scene = json.loads(Path(file).read_text(encoding="utf-8"))
    except ValueError as error:  # of UTF-8 or of JSON
        raise InvalidArgument(f"{file}: not JSON: {error}", (Violation("scene", f"not JSON: {error}"),)) from None
    if not isinstance(scene, dict):
        raise _wrong("scene", scene, "must be an object")
    return scene


def _wrong(path: str, value: Any, rule: str) -> InvalidArgument:
    description = f"{reprlib.repr(value)}: {rule}"
    return InvalidArgument(f"{path}: {description}", (Violation(path, description),))


def to_dict(scene: SceneLike) -> dict[str, Any]:
    """Returns the JSON form of a scene as a dict, with the proto's field names."""
    description: dict[str, Any] = json_format.MessageToDict(to_message(scene), preserving_proto_field_name=True)
    return description


def to_matrix(block: Any, path: str = "matrix") -> pb.Matrix:
    """Returns the message of an array, nested list or mapping. `path` is its name in errors."""
    message = pb.Matrix()
    parse(_in_json(_matrix(_plain(block), path)), message, path)
    return message


def to_array(matrix: pb.Matrix) -> NDArray[Any]:
    values: NDArray[Any] = np.array(matrix.values).reshape(matrix.rows, matrix.cols)
    if not matrix.imaginary:
        return values
    imaginary: NDArray[Any] = np.array(matrix.imaginary).reshape(matrix.rows, matrix.cols)
    numbers: NDArray[Any] = values + 1j * imaginary
    return numbers


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value if np.iscomplexobj(value) else value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def _in_json(value: Any) -> Any:
    """Replaces NaN and the infinities by protobuf's JSON names for them, so that the server reports them."""
    if isinstance(value, Mapping):
        return {key: _in_json(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_in_json(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    return value


def _is_large(block: Any) -> bool:
    return isinstance(block, np.ndarray) and block.ndim in (2, 3) and block.size > LARGE


def set_tensor(tensor: pb.Tensor, block: NDArray[Any]) -> None:
    """Writes an array into an empty message."""
    is_complex = np.iscomplexobj(block)
    tensor.shape.extend(block.shape)
    tensor.data_type = (pb.DATA_TYPE_COMPLEX128 if is_complex
                        else pb.DATA_TYPE_FLOAT64)
    tensor.data = np.ascontiguousarray(block, "<c16" if is_complex else "<f8").tobytes()


def _matrix(block: Any, path: str) -> Any:
    """Returns a nested list, or a flat one for a vector, in the JSON form of a Matrix."""
    if isinstance(block, Mapping):
        return block
    try:
        rows = np.atleast_2d(np.asarray(block))
        values = rows.real.astype(float).ravel().tolist()
    except (ValueError, TypeError):
        raise _wrong(path, block, "must be a matrix of numbers, its rows of one length") from None
    rows = rows.reshape(-1, rows.shape[-1])
    matrix = {"rows": rows.shape[0], "cols": rows.shape[1], "values": values}
    if np.iscomplexobj(rows):
        matrix["imaginary"] = rows.imag.ravel().tolist()
    return matrix


def _ravel(numbers: Any, path: str) -> Any:
    try:
        return np.ravel(numbers).tolist()
    except ValueError:
        raise _wrong(path, numbers, "must be numbers, of every member as many") from None
