"""Attitudes in other forms: rotations of scipy, Euler angles, and the quaternion between two samples."""
from __future__ import annotations

from typing import Any, Mapping

import numpy as np
from numpy.typing import NDArray

from stiefel._results.base import Array
from stiefel._results.extras import imported

_AXES = {"x": 0, "y": 1, "z": 2}


def quaternions(fields: Mapping[str, Array], system: str = "") -> NDArray[np.float64]:
    """Returns the unit quaternions w, x, y, z, body to space, (..., 4), of the field `quaternion` or Q, which takes space to
    body in the right-invariant systems. Raises ValueError if there is neither, or if Q is no rotation in three dimensions."""
    if "quaternion" in fields:
        return np.asarray(fields["quaternion"], float)
    Q = fields.get("Q")
    if Q is None or Q.shape[-2:] != (3, 3) or np.iscomplexobj(Q):
        there = ", ".join(fields)
        raise ValueError(f"an attitude needs the field quaternion, or Q in three dimensions; the fields are {there}")
    if np.abs(Q @ np.swapaxes(Q, -1, -2) - np.eye(3)).max(initial=0) > 0.01:
        raise ValueError("Q: its rows are not orthonormal: it is no rotation")
    return of_matrices(np.asarray(np.swapaxes(Q, -1, -2) if is_right(system) else Q, float))


def is_right(system: str) -> bool:
    """Returns whether the frame of the system takes space to body."""
    return system.startswith("right_")


def of_matrices(Q: NDArray[np.float64]) -> NDArray[np.float64]:
    if (np.linalg.det(Q) < 0).any():
        raise ValueError("Q: its determinant is -1: it is no rotation")
    trace = np.trace(Q, axis1=-2, axis2=-1)
    diagonal = np.diagonal(Q, axis1=-2, axis2=-1)
    # 4 q q^T has these columns; the one with the largest diagonal entry is the most accurate.
    outer = np.empty((*Q.shape[:-2], 4, 4))
    outer[..., 0, 0] = 1 + trace
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[..., i + 1, i + 1] = 1 + 2 * diagonal[..., i] - trace
        outer[..., 0, i + 1] = outer[..., i + 1, 0] = Q[..., k, j] - Q[..., j, k]
        outer[..., j + 1, k + 1] = outer[..., k + 1, j + 1] = Q[..., j, k] + Q[..., k, j]
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(outer, largest[..., None, None], axis=-1)[..., 0]
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def rotation(fields: Mapping[str, Array], system: str) -> Any:
    """Returns a `scipy.spatial.transform.Rotation` that takes body axes to space."""
    transform = imported("scipy.spatial.transform", "scipy")
    q = quaternions(fields, system)
    if q.ndim > 2:
        raise ValueError(f"the attitudes of an ensemble have the shape {q.shape}: a Rotation takes those of one member, such as run.member(0)")
    return transform.Rotation.from_quat(np.roll(q, -1, axis=-1))


def euler_angles(fields: Mapping[str, Array], sequence: str, degrees: bool = False, system: str = "") -> NDArray[np.float64]:
    """Returns the angles (..., 3) of the rotations about three axes whose product is the attitude, body to space.

    `sequence`: three letters; "ZXZ" about the axes that turn with the body, Q = Rz(a) Rx(b) Rz(c), and "zxz" about fixed
    axes, Q = Rz(c) Rx(b) Rz(a), as scipy has them. The middle angle is in [0, pi] if the first and the third axis are the
    same, else in [-pi/2, pi/2]. Where only the sum or the difference of the other two is determined, the third is 0. From
    Bernardes and Viollet, Quaternion to Euler angles conversion, PLOS ONE 17 (2022).
    """
    if len(sequence) != 3 or sequence not in (sequence.upper(), sequence.lower()) or set(sequence.lower()) - set("xyz") \
            or sequence[0] == sequence[1] or sequence[1] == sequence[2]:
        raise ValueError(f"sequence: {sequence!r}: must be three of x, y, z, or of X, Y, Z, with no two equal in a row; the sequence 3-2-1 of a body's axes is ZYX")
    turning = sequence.isupper()
    i, j, k = (_AXES[axis] for axis in (sequence[::-1] if turning else sequence).lower())
    proper = i == k
    if proper:
        k = 3 - i - j
    sign = (i - j) * (j - k) * (k - i) // 2
    q = quaternions(fields, system)
    w, v = q[..., 0], q[..., 1:]
    if proper:
        a, b, c, d = w, v[..., i], v[..., j], v[..., k] * sign
    else:
        a, b, c, d = w - v[..., j], v[..., i] + v[..., k] * sign, v[..., j] + w, v[..., k] * sign - v[..., i]
    middle = 2 * np.arctan2(np.hypot(c, d), np.hypot(a, b))
    half_sum, half_difference = np.arctan2(b, a), np.arctan2(d, c)
    first, third = half_sum - half_difference, half_sum + half_difference
    small, straight = 1e-7 > abs(middle), abs(middle - np.pi) < 1e-7
    lost = small | straight
    if turning:
        third = np.where(lost, np.where(small, 2 * half_sum, 2 * half_difference), third)
        first = np.where(lost, 0.0, first)
    else:
        first = np.where(lost, np.where(small, 2 * half_sum, -2 * half_difference), first)
        third = np.where(lost, 0.0, third)
    if not proper:
        third = third * sign
        middle = middle - np.pi / 2
    angles = np.stack([third, middle, first] if turning else [first, middle, third], axis=-1)
    angles[..., ::2] = (angles[..., ::2] + np.pi) % (2 * np.pi) - np.pi
    return np.degrees(angles) if degrees else angles


def between(first: NDArray[Any], second: NDArray[Any], fraction: NDArray[Any]) -> NDArray[np.float64]:
    """Returns the quaternions on the shortest turn from the first to the second attitude, after that fraction of it."""
    dot = (first * second).sum(-1, keepdims=True)
    second, dot = np.where(dot < 0, -second, second), abs(dot)
    angle = np.arctan2(np.linalg.norm(second - dot * first, axis=-1, keepdims=True), dot)
    s = np.asarray(fraction)[..., None]
    with np.errstate(invalid="ignore", divide="ignore"):
        q = np.where(angle > 1e-12, (np.sin((1 - s) * angle) * first + np.sin(s * angle) * second) / np.sin(angle),
                     (1 - s) * first + s * second)
    return np.asarray(q / np.linalg.norm(q, axis=-1, keepdims=True))


def angle_between(first: NDArray[Any], second: NDArray[Any]) -> NDArray[np.float64]:
    """Returns the angles in radians between attitudes given as unit quaternions."""
    apart = np.minimum(np.linalg.norm(first - second, axis=-1), np.linalg.norm(first + second, axis=-1))
    return np.asarray(4 * np.arcsin(np.minimum(apart / 2, 1)))
