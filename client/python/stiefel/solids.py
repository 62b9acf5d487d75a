"""Homogeneous solids, whose sum is a body: `solids.box(120, (1, 1, 2)) + solids.point(3, at=(0, 0, 1.4))`."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiefel._given.attitudes import of_any
from stiefel._given.numbers import Ensemble, list_of, number, numbers, refused
from stiefel._rotations import to_matrices

__all__ = ["Solid", "box", "cone", "cylinder", "ellipsoid", "point"]
__dir__ = lambda: sorted(__all__)  # noqa: E731

ORIGIN = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid body by its mass, its centre of mass, and its inertia tensor about that centre. The sum of two is the body
    that both are, in the same axes. It may be given as `inertia_tensor` of `stiefel.body_scene`."""

    mass: float  #: kg
    centre: NDArray[Any] = field(repr=False)  #: m
    inertia_tensor: NDArray[Any]  #: 3 x 3, kg m^2

    def __add__(self, other: Solid) -> Solid:
        if not isinstance(other, Solid):
            return NotImplemented
        mass = self.mass + other.mass
        centre = (self.mass * self.centre + other.mass * other.centre) / mass
        return Solid(mass, centre, self.about(centre) + other.about(centre))

    def __radd__(self, other: Any) -> Solid:  # of sum(), which begins with 0
        return self if isinstance(other, int) and other == 0 else NotImplemented

    def about(self, point: Any) -> NDArray[Any]:
        """Returns the inertia tensor about another point, by the theorem of parallel axes."""
        d = self.centre - np.asarray(point, float)
        return np.asarray(self.inertia_tensor + self.mass * (d @ d * np.eye(3) - np.outer(d, d)))


def box(mass: float, size: Any, *, at: Any = ORIGIN, attitude: Any = None) -> Solid:
    """A box with edges `size` along its axes x, y, z. `at`: its centre of mass in the axes of the body. `attitude`: its
    axes in those of the body, a quaternion with the scalar first, a rotation matrix or a Rotation of scipy; numbers that
    were rounded to a few digits stand for the nearest rotation."""
    squares = _lengths("size", size, 3) ** 2
    return _placed(mass, (squares.sum() - squares) / 12, at, attitude)


def ellipsoid(mass: float, semi_axes: Any, *, at: Any = ORIGIN, attitude: Any = None) -> Solid:
    """An ellipsoid with these semi-axes along x, y, z. `at` and `attitude` are those of `box`."""
    squares = _lengths("semi_axes", semi_axes, 3) ** 2
    return _placed(mass, (squares.sum() - squares) / 5, at, attitude)


def cylinder(mass: float, radius: float, height: float, *, at: Any = ORIGIN, attitude: Any = None) -> Solid:
    """A cylinder about its axis z. `at` and `attitude` are those of `box`."""
    r, h = _lengths("radius", radius, 1)[0], _lengths("height", height, 1)[0]
    across = (3 * r * r + h * h) / 12
    return _placed(mass, np.array([across, across, r * r / 2]), at, attitude)


def cone(mass: float, radius: float, height: float, *, at: Any = ORIGIN, attitude: Any = None) -> Solid:
    """A cone about its axis z. `at`: its centre of mass, which is height / 4 above the base. `attitude` is that of `box`."""
    r, h = _lengths("radius", radius, 1)[0], _lengths("height", height, 1)[0]
    across = 3 * (4 * r * r + h * h) / 80
    return _placed(mass, np.array([across, across, 0.3 * r * r]), at, attitude)


def point(mass: float, at: Any) -> Solid:
    """A point mass."""
    return _placed(mass, np.zeros(3), at, None)


def _placed(mass: float, moments: NDArray[Any], at: Any, attitude: Any) -> Solid:
    weight = number("mass", mass, "kg")
    if not weight > 0:
        raise refused("mass", f"{weight!r}: must be above 0")
    centre = numbers("at", at, "m")
    if centre.shape != (3,):
        raise refused("at", f"the shape {centre.shape}: must be (3)")
    R = np.eye(3)
    if attitude is not None:
        given = attitude.as_matrix() if hasattr(attitude, "as_matrix") else attitude
        given = list_of("attitude", given, "", "4", Ensemble(), strict=True, may_be_matrix=True)
        R = to_matrices(of_any("attitude", given, normalize=True))
    return Solid(weight, centre, R @ np.diag(weight * moments) @ R.T)


def _lengths(path: str, given: Any, count: int) -> NDArray[Any]:
    lengths = np.atleast_1d(numbers(path, given, "m"))
    if lengths.shape != (count,) or not (lengths > 0).all():
        raise refused(path, f"{given!r}: must be {count} length{'s' if count > 1 else ''} above 0")
    return lengths
