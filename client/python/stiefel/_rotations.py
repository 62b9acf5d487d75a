"""Rotations in three dimensions as Hamilton's unit quaternions w, x, y, z: matrices, products, rotated vectors. Arrays may have
axes in front, (..., 4), which broadcast."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def of_matrices(Q: NDArray[Any]) -> Array:
    """Returns the quaternions, w >= 0, of rotation matrices (..., 3, 3)."""
    trace, diagonal = np.trace(Q, axis1=-2, axis2=-1), np.diagonal(Q, axis1=-2, axis2=-1)
    # 4 q q^T. The row with the largest diagonal entry, which is at least 1, has q without cancellation.
    outer = np.empty((*Q.shape[:-2], 4, 4))
    outer[..., 0, 0] = 1 + trace
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        outer[..., i + 1, i + 1] = 1 + 2 * diagonal[..., i] - trace
        outer[..., 0, i + 1] = outer[..., i + 1, 0] = Q[..., k, j] - Q[..., j, k]
        outer[..., j + 1, k + 1] = outer[..., k + 1, j + 1] = Q[..., j, k] + Q[..., k, j]
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(outer, largest[..., np.newaxis, np.newaxis], axis=-2)[..., 0, :]
    q = q * np.where(q[..., :1] < 0, -1.0, 1.0)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def to_matrices(q: NDArray[Any]) -> Array:
    """Returns the rotation matrices (..., 3, 3) of quaternions."""
    w, x, y, z = np.moveaxis(np.asarray(q, float), -1, 0)
    rows = [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def inverse(q: NDArray[Any]) -> Array:
    """Returns the quaternions of the inverse rotations."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def product(p: NDArray[Any], q: NDArray[Any]) -> Array:
    """Returns the quaternions of first the rotation q, then p."""
    a, u, b, v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    return np.concatenate([a * b - (u * v).sum(-1, keepdims=True), a * v + b * u + np.cross(u, v)], axis=-1)


def rotated(q: NDArray[Any], x: NDArray[Any]) -> Array:
    """Returns the vectors (..., 3) after the rotations."""
    twice = 2 * np.cross(q[..., 1:], x)
    return np.asarray(x + q[..., :1] * twice + np.cross(q[..., 1:], twice))
