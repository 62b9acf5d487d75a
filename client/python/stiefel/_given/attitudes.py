"""Attitudes in the forms in which people have them: quaternions in both orders, rotation matrices, Rotations of scipy, modified
Rodrigues parameters, Euler angles. All take vectors in body axes to the same vectors in space axes."""
from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiefel import _rotations
from stiefel._given.numbers import refused
from stiefel._given.shown import shown

ORDERS = ("wxyz", "xyzw")
EXACT = 1e-6  #: the largest distance from a rotation that the server takes
ROUNDED = 0.01  #: the largest that `normalize` takes away: the server's for forks


def of_any(path: str, given: NDArray[Any], scalar_last: bool = False, normalize: bool = False) -> NDArray[Any]:
    """Returns the quaternions w, x, y, z, of norm 1, of quaternions (..., 4) or matrices (..., 3, 3), whose columns are the body
    axes in space. `normalize`: takes quaternions of any norm and rounded matrices."""
    if given.shape[-1] == 4:
        return of_norm_1(path, np.roll(given, 1, axis=-1) if scalar_last else given, normalize)
    most = ROUNDED if normalize else EXACT
    worst = float(np.max(np.abs(given @ np.swapaxes(given, -1, -2) - np.eye(3)), initial=0.0))
    if not worst <= most:
        hint = "; normalize=True makes it so" if worst <= ROUNDED else ""
        raise refused(path, f"max |Q Q^T - I| = {worst:.3g}: must be a rotation to {most:g}{hint}")
    if (np.linalg.det(given) < 0).any():
        raise refused(path, "the determinant is -1: must be a rotation, not a reflection; are two axes exchanged?")
    left, _, right = np.linalg.svd(given)
    return _rotations.of_matrices(left @ right if normalize else given)


def of_norm_1(path: str, given: NDArray[Any], normalize: bool = True) -> NDArray[Any]:
    """Returns quaternions (..., 4) of the norm 1. `normalize`: takes any norm above 0, because the direction says all about the
    attitude."""
    sizes = np.linalg.norm(given, axis=-1, keepdims=True)
    if normalize:
        if not ((sizes > 0) & (sizes < np.inf)).all():
            raise refused(path, f"{shown(given.tolist())}: must have a finite norm above 0")
        return np.asarray(given / sizes)
    off = np.ravel(np.abs(sizes - 1))
    if not np.max(off, initial=0.0) <= EXACT:
        size = sizes.ravel()[int(np.argmax(off))]
        hint = "; normalize=True makes it so" * bool(size > 0)
        raise refused(path, f"{shown(given.tolist())} of norm {size:.9g}: must have norm 1 to {EXACT:g}{hint}")
    return given


def of_mrp(sigma: NDArray[Any]) -> NDArray[Any]:
    """Returns the quaternions of modified Rodrigues parameters e tan(angle / 4), (..., 3)."""
    square = np.sum(sigma * sigma, axis=-1, keepdims=True)
    return np.asarray(np.concatenate([1 - square, 2 * sigma], axis=-1) / (1 + square))


def checked(path: str, sequence: Any) -> str:
    """Returns a sequence of axes of Euler angles. Raises InvalidArgument for one that does not determine a rotation."""
    if not re.fullmatch(r"[xyz]{3}|[XYZ]{3}", str(sequence)) or sequence[1] in (sequence[0], sequence[2]):
        raise refused(path, f"{shown(sequence)}: must be three of X, Y, Z for axes that turn with the body, or of x, y, z for fixed "
                            "axes, no two equal in a row; the sequence 3-2-1 of a body's axes is ZYX")
    return str(sequence)


def of_euler(path: str, sequence: Any, angles: NDArray[Any], rates: Any = None) -> tuple[NDArray[Any], NDArray[Any]]:
    """Returns quaternions (..., 4) and angular velocities in body axes (..., 3) of Euler angles (..., 3) in radians and their
    rates. `sequence`: as in scipy, "ZXZ" about the axes that turn with the body, Q = Rz(a) Rx(b) Rz(c), "zxz" about fixed axes,
    Q = Rz(c) Rx(b) Rz(a)."""
    sequence = checked(path, sequence)
    rates = np.zeros_like(angles) if rates is None else rates
    q, omega = np.array([1.0, 0, 0, 0]), np.zeros(3)
    for k in (0, 1, 2) if sequence.isupper() else (2, 1, 0):
        axis, half = np.eye(3)["xyz".index(sequence[k].lower())], angles[..., k, np.newaxis] / 2
        turn = np.concatenate([np.cos(half), np.sin(half) * axis], axis=-1)
        q, omega = _rotations.product(q, turn), _rotations.rotated(_rotations.inverse(turn), omega) + rates[..., k, np.newaxis] * axis
    return q, omega
