"""Arrays on the wire."""
from __future__ import annotations

import math
from typing import Any, Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import Array
from stiefel._results.kinds import as_named
from stiefel.errors import CorruptReply

LARGE = 4096  # numbers; a larger array travels as bytes
_DTYPES: dict[int, np.dtype[Any]] = {
    pb.DATA_TYPE_FLOAT64: np.dtype("<f8"), pb.DATA_TYPE_COMPLEX128: np.dtype("<c16"),
    pb.DATA_TYPE_FLOAT32: np.dtype("<f4"), pb.DATA_TYPE_INT64: np.dtype("<i8"),
}


def require(holds: bool, fault: str) -> None:
    if not holds:
        raise CorruptReply(f"the reply breaks the protocol: {fault}")


def decode(tensor: pb.Tensor) -> Array:
    """Returns a read-only view of the tensor's bytes. Raises CorruptReply if they are not as many as the shape says."""
    shape, data = tuple(tensor.shape), tensor.data  # protobuf copies `data` at each access
    require(tensor.data_type in _DTYPES, f"an array has the unknown data type {tensor.data_type}")
    dtype = _DTYPES[tensor.data_type]
    require(len(data) == dtype.itemsize * math.prod(shape), f"an array of the shape {shape} has {len(data)} bytes")
    return np.frombuffer(data, dtype).reshape(shape)


def decode_fields(fields: Iterable[pb.Field]) -> dict[str, Array]:
    return {field.name: decode(field.value) for field in fields}


def named(fields: Mapping[str, Array], behind: int = 0) -> dict[str, Array]:
    """Returns arrays of matrices as the caller gets them: vectors and numbers without their axes of length 1. `behind`: how
    many axes stand behind those of the field. Raises CorruptReply if such an axis has another length."""
    try:
        return {name: as_named(name, array, behind) for name, array in fields.items()}
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in fields.items())
        raise CorruptReply(f"a vector is sent as one row, a number as one row of one: {shapes}") from None


def set_tensor(tensor: pb.Tensor, block: NDArray[Any]) -> None:
    """Writes an array into an empty message."""
    tensor.shape.extend(block.shape)
    tensor.data_type = pb.DATA_TYPE_COMPLEX128 if np.iscomplexobj(block) else pb.DATA_TYPE_FLOAT64
    tensor.data = np.ascontiguousarray(block, _DTYPES[tensor.data_type]).tobytes()


def matrix(array: Array) -> pb.Matrix:
    """Returns an array as a Matrix, whose rows are all axes of the array but the last."""
    rows = array.reshape(math.prod(array.shape[:-1]), array.shape[-1])
    imaginary = np.imag(rows).ravel().tolist() if np.iscomplexobj(rows) else None
    return pb.Matrix(rows=rows.shape[0], cols=rows.shape[1], values=np.real(rows).ravel().tolist(), imaginary=imaginary)


def to_array(matrix: pb.Matrix) -> NDArray[Any]:
    values = np.array(matrix.values) + 1j * np.array(matrix.imaginary) if matrix.imaginary else np.array(matrix.values)
    return values.reshape(matrix.rows, matrix.cols)


def blocks_of(scene: pb.Scene) -> dict[str, NDArray[Any]]:
    """Returns the blocks of the initial state, (rows, cols) or, where they are given so, (members, rows, cols)."""
    return {**{name: to_array(block) for name, block in sorted(scene.initial.items())},
            **{name: decode(tensor) for name, tensor in sorted(scene.initial_tensors.items())}}


def put_block(scene: pb.Scene, name: str, block: Array) -> None:
    """Sets a block of a scene's initial state, as bytes if it is large."""
    scene.initial.pop(name, None)
    scene.initial_tensors.pop(name, None)
    if block.size > LARGE:
        set_tensor(scene.initial_tensors[name], block)
    else:
        scene.initial[name].CopyFrom(matrix(block))
