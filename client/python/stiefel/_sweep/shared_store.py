"""Lets workers that see the store of a sweep write their chunks into it themselves.

The sweep writes a random challenge into the group, and each task has the challenge's SHA-256. A worker that opens the
group at the same path and finds a text with that SHA-256 sees the same store. It writes the chunk's arrays, then the
chunk's mark, and returns the mark instead of the arrays. The sweep reads the chunk back and compares the mark. If the
two machines see the store in different states, the marks differ, and the chunk is computed again.
"""
from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, Mapping, Optional, Union

import numpy as np
from numpy.typing import NDArray

CHALLENGE, MARKS = "stiefel_challenge", "done"


@dataclass(frozen=True)
class Place:
    """The place of a chunk in a store."""

    path: str  #: the absolute path of the store
    challenge: str  #: SHA-256 of the challenge in the group
    chunk: int  #: the number of the chunk
    begin: int  #: the chunk's first row in each array
    end: int  #: one past its last row


@dataclass(frozen=True)
class Written:
    """The mark of a chunk that its worker wrote into the store."""

    mark: bytes
    warnings: tuple[str, ...] = ()  #: of the server about the scene


def mark_of(arrays: Mapping[str, NDArray[Any]]) -> NDArray[np.uint8]:
    """Returns the SHA-256 of the names, types, shapes and numbers of a chunk's arrays."""
    digest = hashlib.sha256()
    for name in sorted(arrays):
        values = np.ascontiguousarray(arrays[name])
        digest.update(f"{name} {values.dtype.str} {values.shape}\n".encode() + values.tobytes())
    return np.frombuffer(digest.digest(), np.uint8)


def write(group: Any, chunk: int, begin: int, end: int, arrays: Mapping[str, NDArray[Any]]) -> NDArray[np.uint8]:
    """Writes a chunk's arrays, then its mark, and returns the mark."""
    for name, values in arrays.items():
        group[name][begin:end] = values
    mark = mark_of(arrays)
    group[MARKS][chunk] = mark
    return mark


def write_if_seen(place: Optional[Place], arrays: Mapping[str, NDArray[Any]]) -> Union[Written, Mapping[str, NDArray[Any]]]:
    """Writes the chunk if this process sees the store and can write to it. Returns `Written`, or else the arrays."""
    group = _seen(place) if place else None
    if group is None or place is None:
        return arrays
    try:
        return Written(write(group, place.chunk, place.begin, place.end, arrays).tobytes())
    except Exception:  # a full or read-only disk; each kind of store raises its own exceptions
        return arrays


def _seen(place: Place) -> Optional[Any]:
    try:
        import zarr

        group = zarr.open_group(place.path, mode="r+")
        challenge = str(group.attrs.get(CHALLENGE, ""))
    except Exception:  # no Zarr, no such path, no permission
        return None
    return group if hashlib.sha256(challenge.encode()).hexdigest() == place.challenge else None
