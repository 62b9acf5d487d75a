"""Attitudes in other forms: rotations of scipy, and the rates of Euler angles."""
from __future__ import annotations

import re
from typing import Any, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._results.base import Array
from stiefel._results.extras import imported
from stiefel._rotations import of_matrices


def quaternions(fields: Mapping[str, Array], side: Optional[str] = "") -> NDArray[np.float64]:
    """Returns the unit quaternions w, x, y, z, body to space, (..., 4), of the field `quaternion` or Q, which takes space to
    body if `side` is "right". Raises ValueError if there is neither, or if Q is no rotation in three dimensions."""
    if "quaternion" in fields:
        return np.asarray(fields["quaternion"], float)
    Q = fields.get("Q")
    if Q is None or Q.shape[-2:] != (3, 3) or np.iscomplexobj(Q):
        there = ", ".join(fields)
        raise ValueError(f"an attitude needs the field quaternion, or Q in three dimensions; the fields are {there}")
    if side is None:
        raise ValueError("Q: the server did not say whether it takes body to space; ask for the field quaternion")
    if np.abs(Q @ np.swapaxes(Q, -1, -2) - np.eye(3)).max(initial=0) > 0.01:
        raise ValueError("Q: its rows are not orthonormal: it is no rotation")
    if (np.linalg.det(Q) < 0).any():
        raise ValueError("Q: its determinant is -1: it is no rotation")
    return of_matrices(np.asarray(np.swapaxes(Q, -1, -2) if side == "right" else Q, float))


def rotation(fields: Mapping[str, Array], side: Optional[str]) -> Any:
    """Returns a `scipy.spatial.transform.Rotation` that takes body axes to space."""
    q = quaternions(fields, side)
    if q.ndim > 2:
        raise ValueError(f"the attitudes of an ensemble have the shape {q.shape}: a Rotation takes those of one member, such as run.member(0)")
    return imported("scipy.spatial.transform", "scipy").Rotation.from_quat(np.roll(q, -1, axis=-1))


def checked(sequence: Any) -> str:
    """Returns a sequence of axes. Raises ValueError for one that does not determine a rotation."""
    if not re.fullmatch(r"[xyz]{3}|[XYZ]{3}", str(sequence)) or sequence[1] in (sequence[0], sequence[2]):
        raise ValueError(f"sequence: {sequence!r}: must be three of x, y, z, or of X, Y, Z, with no two equal in a row; the sequence 3-2-1 of a body's axes is ZYX")
    return str(sequence)


def rates_of_angles(sequence: str, angles: NDArray[Any], omega: NDArray[Any]) -> NDArray[np.float64]:
    """Returns the rates (samples, 3) of Euler angles in radians, from angular velocities in body axes.

    Of Q = R1(a) R2(b) R3(c), omega is the sum of the rates times the axes c1, c2, c3 in the body. c2 is orthogonal to both
    others. Where c1 and c3 are parallel only the sum or the difference of their rates is determined, and both are not finite.
    """
    Rotation = imported("scipy.spatial.transform", "scipy").Rotation
    order = slice(None) if sequence.isupper() else slice(None, None, -1)  # Rz(c) Ry(b) Rx(a) about fixed axes
    axes, (_, b, c) = np.eye(3)[["xyz".index(axis) for axis in sequence.lower()]][order], angles[:, order].T
    last = Rotation.from_rotvec(c[:, None] * axes[2]).inv()
    c1 = (last * Rotation.from_rotvec(b[:, None] * axes[1]).inv()).apply(axes[0])
    first, middle, third = (np.sum(omega * axis, axis=1) for axis in (c1, last.apply(axes[1]), axes[2]))
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = c1 @ axes[2]
        return np.stack([(first - cosine * third) / (1 - cosine**2), middle, (third - cosine * first) / (1 - cosine**2)], axis=1)[:, order]
