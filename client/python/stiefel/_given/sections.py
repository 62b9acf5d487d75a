"""The plane of a Poincaré section and the coordinates of its points, as a caller gives them."""
from __future__ import annotations

import re
from typing import Any, Callable, Mapping, Sequence, Union

import numpy as np

from stiefel._given.initial import retold
from stiefel._given.numbers import number, numbers, refused
from stiefel._given.shown import shown
from stiefel._results.base import Array
from stiefel.errors import InvalidArgument, Violation

#: Coefficients by field, or a function of the section.
Coordinate = Union[Mapping[str, Any], Callable[[Any], Any]]


def to_section(section: Mapping[str, Any], level: float, direction: str, coordinates: Sequence[Coordinate]) -> dict[str, Any]:
    """Returns the event of a crossing."""
    if not isinstance(coordinates, (list, tuple)):
        raise refused("coordinates", f"{shown(coordinates)}: must be several mappings from fields to coefficients, or functions")
    if not isinstance(section, Mapping) or not section:
        raise refused("section", f"{shown(section)}: must be a mapping from fields to their coefficients")
    (name, coefficients), *more = ((name, numbers(f"section.{name}", given)) for name, given in section.items())
    return {"field": name, "coefficients": coefficients, "plus": dict(more), "level": number("level", level), "direction": direction}


def of_section(error: InvalidArgument, asked: int) -> InvalidArgument:
    """Returns the error of a search for a section's event in the words of the section. `asked`: how many of the fields the
    caller named; the others are those of the section and of its coordinates."""
    told: dict[str, Violation] = {}
    for one in error.violations:
        index = re.fullmatch(r"fields\[(\d+)\]", one.field)
        place = "coordinates" if index and int(index[1]) >= asked else re.sub(
            r"^events\[0\]\.(direction|level)$", r"\1", one.field)
        told.setdefault(one.description, Violation(re.sub(r"^events\[0\].*", "section", place), one.description))
    return retold(error, told.values())


def column(path: str, section: Any, of: Coordinate) -> Array:
    """Returns one coordinate of every crossing."""
    if isinstance(of, Mapping):
        total: Array = np.zeros(len(section))
        for name, coefficients in of.items():
            given, values = numbers(f"{path}.{name}", coefficients), section[name]
            if len(section) and given.size != values[0].size:
                raise refused(f"{path}.{name}", f"the shape {given.shape}: must be {values.shape[1:]}, that of the field")
            total = total + values.reshape(len(section), given.size) @ given.ravel()
        return total
    if not callable(of):
        raise refused(path, f"{shown(of)}: must be a mapping from fields to coefficients, or a function of the section")
    values = np.asarray(of(section), float)
    if values.shape != (len(section),):
        raise refused(path, f"the shape {values.shape}: must be one number for each of {len(section)} crossings")
    return values


def columns(section: Any, coordinates: Sequence[Coordinate]) -> Array:
    """Returns the points: (crossings, coordinates)."""
    return np.stack([column(f"coordinates[{k}]", section, of) for k, of in enumerate(coordinates)], axis=1) \
        if coordinates else np.empty((len(section), 0))
