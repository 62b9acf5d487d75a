"""A rigid body in three dimensions, from a scene and a trajectory: attitude, momentum, principal axes."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping, Optional

import numpy as np

from stiefel._results.base import Array
from stiefel._rotations import to_matrices

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
