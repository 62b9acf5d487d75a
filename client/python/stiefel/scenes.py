"""Scenes: a dict, the path of a scene file, or the message itself."""
from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Mapping, Union

import numpy as np
from google.protobuf import json_format

from stiefel.errors import InvalidArgument, Violation
from stiefel.v1 import scene_pb2

SceneLike = Union[Mapping[str, Any], str, "os.PathLike[str]", scene_pb2.Scene]


def to_message(scene: SceneLike) -> scene_pb2.Scene:
    """The message of a scene. In a dict, matrices may be arrays and numbers numpy's."""
    if isinstance(scene, scene_pb2.Scene):
        return scene
    if not isinstance(scene, Mapping):
        scene = json.loads(Path(scene).read_text(encoding="utf-8"))
    description = _plain(scene)
    initial = description.get("initial")
    if isinstance(initial, dict):
        description["initial"] = {name: _matrix(block) for name, block in initial.items()}
    try:
        return json_format.ParseDict(description, scene_pb2.Scene())
    except json_format.ParseError as error:
        raise InvalidArgument(f"not a scene: {error}", (Violation("scene", str(error)),)) from None


def to_dict(scene: SceneLike) -> dict[str, Any]:
    """The JSON form, with the proto's field names."""
    return json_format.MessageToDict(to_message(scene), preserving_proto_field_name=True)


def to_matrix(block: Any) -> scene_pb2.Matrix:
    """The message of an array, nested list or mapping."""
    return json_format.ParseDict(_matrix(_plain(block)), scene_pb2.Matrix())


def to_array(matrix: scene_pb2.Matrix) -> np.ndarray:
    values = np.array(matrix.values).reshape(matrix.rows, matrix.cols)
    if not matrix.imaginary:
        return values
    return values + 1j * np.array(matrix.imaginary).reshape(matrix.rows, matrix.cols)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value if np.iscomplexobj(value) else value.tolist()
    return value.item() if isinstance(value, np.generic) else value


def _matrix(block: Any) -> Any:
    """A nested list, or a flat one for a vector, as a Matrix."""
    if isinstance(block, Mapping):
        return block
    rows = np.atleast_2d(np.asarray(block))
    matrix = {"rows": rows.shape[0], "cols": rows.shape[1],
              "values": rows.real.astype(float).ravel().tolist()}
    if np.iscomplexobj(rows):
        matrix["imaginary"] = rows.imag.ravel().tolist()
    return matrix
