"""A rigid body in three dimensions, from a scene and a trajectory: attitude in every form, momentum, principal axes."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._results.base import Array
from stiefel._results.extras import imported
from stiefel._rotations import of_matrices, to_matrices

Trajectory = Any  # a `stiefel.Trajectory`


@dataclass(frozen=True)
class Principal:
    """Principal moments of inertia in ascending order, (3,), and the axes, the rows of a matrix, in the body axes of the
    scene. Axes that are not those of the scene have a positive largest component, but b, which makes them right-handed."""

    moments: Array
    axes: Array
    names: tuple[str, ...]  #: x, y, z where the body axes of the scene are principal, else a, b, c

    @property
    def distinct(self) -> bool:
        """Whether no two moments are equal, so that there is a separatrix."""
        return bool(np.diff(self.moments).min() > 1e-9 * self.moments[2])

    def velocity(self, momentum: Array) -> Array:
        """Returns angular velocities, (..., 3), for momenta, both in the body axes of the scene."""
        return (momentum @ self.axes.T / self.moments) @ self.axes

    def momentum(self, velocity: Array) -> Array:
        return (velocity @ self.axes.T * self.moments) @ self.axes


def principal(scene: Mapping[str, Any], member: Optional[int]) -> Principal:
    """Returns the principal axes of a scene with `body`, or with `inertia` of three numbers."""
    def numbers(values: Any, count: int) -> Array:
        flat = np.asarray(values, dtype=float).reshape(-1, count)
        one: Array = flat[member if member is not None and len(flat) > 1 else 0]
        return one

    body = scene.get("body", {})
    if "inertia_tensor" in body:
        xx, yy, zz, xy, xz, yz = numbers(body["inertia_tensor"], 6)
        moments, columns = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        axes = columns.T * np.copysign(1, columns[np.argmax(abs(columns), axis=0), range(3)])[:, None]
        axes[1] *= np.copysign(1, np.linalg.det(axes))
        return Principal(moments, axes, ("a", "b", "c"))
    if "moments" in body:
        moments = numbers(body["moments"], 3)
    else:
        moments = np.sum(numbers(scene["inertia"], 3)) - numbers(scene["inertia"], 3)
    order = np.argsort(moments, kind="stable")
    return Principal(moments[order], np.eye(3)[order], tuple("xyz"[k] for k in order))


def is_body(trajectory: Trajectory) -> bool:
    """Returns whether the trajectory has the momentum or the angular velocity of a body in three dimensions."""
    there = trajectory.fields
    return "angular_velocity" in there or (bool(trajectory._side) and "M" in there and there["M"].shape[-2:] == (3, 3))


def momenta(scene: Mapping[str, Any], trajectory: Trajectory, member: Optional[int]) -> Array:
    """Returns the momenta in the body axes of the scene, (samples, 3)."""
    fields = trajectory.fields
    if "angular_velocity" in fields:
        return principal(scene, member).momentum(vectors(fields["angular_velocity"], member))
    M = matrices(fields["M"], member)
    return (-1 if trajectory._side == "right" else 1) * M[:, [2, 0, 1], [1, 2, 0]]  # M = hat(m)


def velocities(scene: Mapping[str, Any], trajectory: Trajectory, member: Optional[int]) -> Array:
    """Returns the angular velocities in the body axes of the scene, (samples, 3)."""
    there = trajectory.fields.get("angular_velocity")
    if there is not None:
        return vectors(there, member)
    return principal(scene, member).velocity(momenta(scene, trajectory, member))


def attitudes(trajectory: Trajectory, member: Optional[int]) -> Optional[Array]:
    """Returns the rotations from body to space, (samples, 3, 3); None where the trajectory has none."""
    fields = trajectory.fields
    if "quaternion" in fields:
        return to_matrices(vectors(fields["quaternion"], member))
    if not trajectory._side or "Q" not in fields or fields["Q"].shape[-2:] != (3, 3):
        return None
    Q = matrices(fields["Q"], member)
    return Q.transpose(0, 2, 1) if trajectory._side == "right" else Q


def matrices(values: Array, member: Optional[int]) -> Array:
    """Returns the samples of one motion as (samples, rows, cols)."""
    values = values if member is None else values[:, member]
    return values if values.ndim == 3 else values.reshape(len(values), 1, -1)


def vectors(values: Array, member: Optional[int]) -> Array:
    """Returns the samples of one motion as (samples, cols)."""
    return matrices(values, member)[:, 0]


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
