"""What a field is, by its name: how many axes a value has, the names of its numbers, and its unit."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from stiefel._results.base import Array


@dataclass(frozen=True)
class Kind:
    """A kind of field. Every value of a field travels as a matrix; `axes` says how many axes it has for the caller."""

    axes: int = 2  #: 0 for a number, 1 for a vector, 2 for a matrix
    columns: tuple[str, ...] = ()  #: the names of a vector's numbers in a table; empty: NAME[0], NAME[1], ...
    unit: Optional[str] = None  #: the unit in a scene with `body`; None where a scene gives none


def _xyz(name: str, first: str = "") -> tuple[str, ...]:
    return tuple(f"{name}_{axis}" for axis in first + "xyz")


_KINDS = {
    "quaternion": Kind(1, _xyz("q", "w"), "1"),
    "angular_velocity": Kind(1, _xyz("omega"), "rad/s"),
    "angular_velocity_space": Kind(1, _xyz("omega_space"), "rad/s"),
    "momentum_space": Kind(1, _xyz("momentum_space"), "kg m^2/s"),
    "euler_angles": Kind(1, (), "rad"), "euler_rates": Kind(1, (), "rad/s"),
    "epsilon": Kind(0),
    **dict.fromkeys(("q", "qdot", "p"), Kind(1)),
    "Q": Kind(unit="1"), "M": Kind(unit="kg m^2/s"), "Omega": Kind(unit="rad/s"),
}
_MATRIX = Kind()


def kind_of(field: str) -> Kind:
    """Returns the kind of a field. A name that is not known is that of a matrix."""
    return _KINDS.get(field.rpartition("_")[0] if field.startswith("euler_") and field not in _KINDS else field, _MATRIX)


def as_named(field: str, array: Array, behind: int = 0) -> Array:
    """Returns an array of matrices (..., rows, cols) without the axes that a vector or a number does not have. `behind`:
    how many axes of the array stand behind those of the field. Raises ValueError if such an axis is not of length 1."""
    rows = array.ndim - 2 - behind
    gone = {0: (rows, rows + 1), 1: (rows,), 2: ()}[kind_of(field).axes]
    return array.squeeze(gone) if gone else array
