"""Joins arrays that travel in parts because they are larger than a message."""
from __future__ import annotations

import math
from typing import Iterable

import numpy as np

from stiefel import v1 as pb
from stiefel.arrays import Array, decode, dtype_of
from stiefel.errors import CorruptReply


class Assembly:
    """Takes arrays, whole or in part, in the order in which they arrive, and returns them whole."""

    def __init__(self) -> None:
        self._whole: dict[str, Array] = {}
        self._parts: list[bytes] = []
        self._name, self._dtype = "", np.dtype(float)
        self._shape: tuple[int, ...] = ()

    def take(self, fields: Iterable[pb.Field]) -> None:
        """Takes arrays. Raises CorruptReply if a part does not continue the part before it."""
        for field in fields:
            if not field.whole_shape:
                self._whole[field.name] = decode(field.value)
                continue
            if field.offset == 0:
                self._join()
                self._name, self._shape, self._dtype = field.name, tuple(field.whole_shape), dtype_of(field.value)
            begun = sum(map(len, self._parts))
            if field.name != self._name or field.offset * self._dtype.itemsize != begun:
                raise _incomplete(field.name)
            self._parts.append(field.value.data)

    @property
    def begun(self) -> bool:
        """Whether something was taken since the last `finish`."""
        return bool(self._whole or self._parts)

    def finish(self) -> dict[str, Array]:
        """Returns all arrays by name and leaves this object empty. Raises CorruptReply if one is incomplete."""
        self._join()
        whole, self._whole = self._whole, {}
        return whole

    def _join(self) -> None:
        if not self._parts:
            return
        data = b"".join(self._parts)
        if len(data) != math.prod(self._shape) * self._dtype.itemsize:
            raise _incomplete(self._name)
        self._whole[self._name] = np.frombuffer(data, self._dtype).reshape(self._shape)
        self._parts = []


def _incomplete(name: str) -> CorruptReply:
    return CorruptReply(f"a part of the array {name} is missing")
