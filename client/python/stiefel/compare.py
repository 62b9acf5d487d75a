"""Equality by value of objects that hold arrays, so that two answers can be compared with `==`."""
from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


def same(first: Any, second: Any) -> bool:
    """Returns whether both hold the same numbers. A NaN equals a NaN, and -0.0 equals 0.0."""
    if isinstance(first, np.ndarray) or isinstance(second, np.ndarray):
        numbers = all(np.asarray(one).dtype.kind in "fc" for one in (first, second))  # others are never NaN
        return np.array_equal(first, second, equal_nan=numbers)
    if isinstance(first, dict) and isinstance(second, dict):
        return first.keys() == second.keys() and all(same(first[key], second[key]) for key in first)
    if isinstance(first, tuple) and isinstance(second, tuple):
        return len(first) == len(second) and all(map(same, first, second))
    return bool(first == second)


class ByValue:
    """Base of dataclasses that are compared field by field, without the fields that have `compare=False`.

    The dataclass must have eq=False. It cannot be hashed, because it may hold arrays.
    """

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(same(getattr(self, field.name), getattr(other, field.name))
                   for field in dataclasses.fields(self) if field.compare)
