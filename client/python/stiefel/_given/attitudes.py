"""Attitudes in the forms in which people have them: quaternions in both orders, rotation matrices, Rotations of scipy, and
modified Rodrigues parameters. All take vectors in body axes to the same vectors in space axes."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiefel._given.numbers import numbers, refused
from stiefel._given.shown import shown

ORDERS = ("wxyz", "xyzw")
EXACT = 1e-6  #: the largest distance from a rotation that the server takes
ROUNDED = 0.01  #: the largest that `normalize` makes one


def quaternions(path: str, given: Any, order: str = "wxyz", normalize: bool = False,
                rounded: str = "normalize=True") -> NDArray[Any]:
    """Returns Hamilton's unit quaternions w, x, y, z, (4) or (members, 4), of quaternions, of matrices (3, 3) or
    (members, 3, 3), or of a Rotation of scipy, whose `apply` takes body axes to space axes. `normalize`: takes quaternions of
    any norm and rounded matrices. `rounded`: what errors say does so."""
    if order not in ORDERS:
        raise refused("order", f"{order!r}: must be one of {', '.join(ORDERS)}")
    if hasattr(given, "as_quat") and hasattr(given, "as_matrix"):
        return np.roll(np.asarray(given.as_quat(), float), 1, axis=-1)
    array = numbers(path, given)
    if array.shape[-2:] == (3, 3):
        return _of_matrices(path, array, normalize, rounded)
    if array.shape[-1:] != (4,) or array.ndim > 2:
        raise refused(path, f"the shape {array.shape}: must be (4), (3, 3), (members, 4) or (members, 3, 3)")
    q = array if order == "wxyz" else np.roll(array, 1, axis=-1)
    if normalize:
        return of_norm_1(path, q)
    sizes = np.linalg.norm(q, axis=-1)
    off = np.ravel(np.abs(sizes - 1))
    if not np.max(off, initial=0.0) <= EXACT:
        k = int(np.argmax(off))
        hint = f"; {rounded} makes it so" * bool(sizes.ravel()[k] > 0)
        raise refused(path, f"{shown(array.tolist())} of norm {sizes.ravel()[k]:.9g}: must have norm 1 to {EXACT:g}{hint}")
    return q


def of_norm_1(path: str, given: NDArray[Any]) -> NDArray[Any]:
    """Returns quaternions (..., 4) of any norm above 0 with the norm 1: their directions say all about the attitude."""
    sizes = np.linalg.norm(given, axis=-1, keepdims=True)
    if not ((sizes > 0) & (sizes < np.inf)).all():
        raise refused(path, f"{shown(given.tolist())}: must have a finite norm above 0")
    return np.asarray(given / sizes)


def matrices(path: str, given: Any, order: str = "wxyz", normalize: bool = False) -> NDArray[Any]:
    """Returns rotation matrices, (3, 3) or (members, 3, 3), whose columns are the body axes in space axes."""
    w, x, y, z = np.moveaxis(quaternions(path, given, order, normalize), -1, 0)
    rows = [[w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def of_mrp(path: str, given: Any) -> NDArray[Any]:
    """Returns the quaternions of modified Rodrigues parameters e tan(angle / 4), (3) or (members, 3)."""
    sigma = numbers(path, given)
    if sigma.shape[-1:] != (3,) or sigma.ndim > 2:
        raise refused(path, f"the shape {sigma.shape}: must be (3) or (members, 3)")
    square = np.sum(sigma * sigma, axis=-1, keepdims=True)
    return np.asarray(np.concatenate([1 - square, 2 * sigma], axis=-1) / (1 + square))


def _of_matrices(path: str, given: NDArray[Any], normalize: bool, rounded: str) -> NDArray[Any]:
    defect = np.abs(given @ np.swapaxes(given, -1, -2) - np.eye(3)).max(axis=(-1, -2))
    worst = float(np.max(defect, initial=0.0))
    if not worst <= (ROUNDED if normalize else EXACT):
        hint = f"; {rounded} makes it so" if worst <= ROUNDED else ""
        raise refused(path, f"max |Q Q^T - I| = {worst:.3g}: must be a rotation to {ROUNDED if normalize else EXACT:g}{hint}")
    if (np.linalg.det(given) < 0).any():
        raise refused(path, "the determinant is -1: must be a rotation, not a reflection; are two axes exchanged?")
    left, _, right = np.linalg.svd(given)
    Q = left @ right if normalize else given
    # Of the four numbers 4 w^2, 4 x^2, ... the largest is at least 1; its row has the quaternion without cancellation.
    d = np.einsum("...ii->...i", Q)
    squares = np.concatenate([1 + d.sum(-1, keepdims=True), 1 + 2 * d - d.sum(-1, keepdims=True)], axis=-1)
    x, y, z = Q[..., 2, 1] - Q[..., 1, 2], Q[..., 0, 2] - Q[..., 2, 0], Q[..., 1, 0] - Q[..., 0, 1]
    xy, xz, yz = Q[..., 0, 1] + Q[..., 1, 0], Q[..., 0, 2] + Q[..., 2, 0], Q[..., 1, 2] + Q[..., 2, 1]
    products = np.stack([np.stack(row, -1) for row in ((squares[..., 0], x, y, z), (x, squares[..., 1], xy, xz),
                                                       (y, xy, squares[..., 2], yz), (z, xz, yz, squares[..., 3]))], -2)
    which = np.argmax(squares, axis=-1)[..., np.newaxis, np.newaxis]
    q = np.take_along_axis(products, which, axis=-2)[..., 0, :]
    q = q * np.where(q[..., :1] < 0, -1.0, 1.0)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))
