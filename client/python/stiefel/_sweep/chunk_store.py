"""A Zarr group with the finished chunks of one sweep.

The process that runs the sweep creates the group and writes to it; workers that see the group write their chunks
themselves (shared_store). After the arrays of a chunk its mark is written, the SHA-256 of the arrays. A chunk whose
mark is missing or wrong is computed again.
"""
from __future__ import annotations

import hashlib
import json
import os
import secrets
from pathlib import Path
from typing import Any, Iterator, Mapping, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel.errors import InvalidArgument, Violation
from stiefel._sweep.plan import Plan
from stiefel._sweep.shared_store import CHALLENGE, MARKS, Place, Written, mark_of, write

_SWEEP, _SHAPES = "stiefel_sweep", "stiefel_arrays"
_SIZE = 32  # bytes of a mark


class Store:
    """The store of one sweep, new or with finished chunks of the same sweep. Raises InvalidArgument if the group holds
    another sweep or something else."""

    def __init__(self, store: Any, plan: Plan):
        self._plan = plan
        self._group = _open(store)
        self._arrays: dict[str, Any] = {}
        self._complete = False  # whether all arrays of the sweep are known to exist
        self._path = os.path.abspath(store) if isinstance(store, (str, os.PathLike)) else None
        self._challenge = ""  # this run's challenge; empty until a worker may write
        _, first, rows = plan.chunks[0]
        # Whether no two chunks of the sweep share a block of an array.
        self._apart = all(begin % (rows - first) == 0 and end - begin <= rows - first for _, begin, end in plan.chunks)
        found = self._group.attrs.get(_SWEEP)
        identity = plan.identity()
        if found is None and len(list(self._group)) > 0:
            raise _wrong(store, "holds something else: must be empty or the store of this sweep")
        if found is not None and found != identity:
            differs = ", ".join(_differences(found, identity))
            raise _wrong(store, f"is the store of another sweep: {differs} differ; must be empty or the store of this sweep")
        if found is None:
            self._group.attrs[_SWEEP] = identity
        if MARKS not in self._group:
            self._create(MARKS, (len(plan.chunks), _SIZE), np.dtype("u1"), 1, (f"{MARKS}_chunk", f"{MARKS}_byte"))
        self._marks = self._group[MARKS]

    def finished(self) -> Iterator[tuple[int, dict[str, NDArray[Any]]]]:
        """Yields the finished chunks with their arrays."""
        marks = np.asarray(self._marks[:])
        names = self._group.attrs.get(_SHAPES, [])
        if any(name not in self._group for name in names):
            return
        for chunk in np.flatnonzero(marks.any(axis=1)).tolist():
            _, begin, end = self._plan.chunks[chunk]
            arrays = {name: np.asarray(self._array(name)[begin:end]) for name in names}
            if mark_of(arrays).tobytes() == marks[chunk].tobytes():
                yield chunk, arrays

    def put(self, chunk: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Writes a chunk's arrays, then its mark."""
        _, begin, end = self._plan.chunks[chunk]
        if not self._complete:
            self._create_all(arrays)
        write(self._group, chunk, begin, end, arrays)

    def place(self, chunk: int) -> Optional[Place]:
        """Returns where a worker may write the chunk. None while arrays are missing, for a store without a path, and if
        chunks share blocks of an array, into which two workers could write at the same time."""
        if self._path is None or not self._complete or not self._apart:
            return None
        if not self._challenge:
            self._challenge = secrets.token_hex(32)
            self._group.attrs[CHALLENGE] = self._challenge
        _, begin, end = self._plan.chunks[chunk]
        return Place(self._path, hashlib.sha256(self._challenge.encode()).hexdigest(), chunk, begin, end)

    def read(self, chunk: int, written: Written) -> Optional[dict[str, NDArray[Any]]]:
        """Returns the arrays that a worker wrote. Returns None if they do not have the worker's mark: this process sees
        the store in another state, so that from now on no worker may write."""
        _, begin, end = self._plan.chunks[chunk]
        try:
            arrays = {name: np.asarray(self._array(name)[begin:end]) for name in self._group.attrs[_SHAPES]}
            if mark_of(arrays).tobytes() == written.mark == np.asarray(self._marks[chunk]).tobytes():
                return arrays
        except Exception:  # a file that is not there yet; each kind of store raises its own exceptions
            pass
        self._path = None
        return None

    def _create_all(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        _, begin, end = self._plan.chunks[0]
        for name, values in arrays.items():
            if name not in self._group:
                shape = (len(self._plan.order), *values.shape[1:])
                dims = ("point", *(f"{name}_{k}" for k in range(values.ndim - 1)))
                self._create(name, shape, values.dtype, end - begin, dims)
        self._group.attrs[_SHAPES] = sorted(arrays)
        self._complete = True

    def _create(self, name: str, shape: tuple[int, ...], dtype: np.dtype[Any], rows: int, dims: tuple[str, ...]) -> None:
        make = getattr(self._group, "create_array", None) or self._group.create_dataset  # zarr 3, else zarr 2
        array = make(name, shape=shape, dtype=dtype, chunks=(rows, *shape[1:]), fill_value=0)
        array.attrs["_ARRAY_DIMENSIONS"] = list(dims)

    def _array(self, name: str) -> Any:
        if name not in self._arrays:
            self._arrays[name] = self._group[name]
        return self._arrays[name]


def _open(store: Any) -> Any:
    try:
        import zarr
    except ImportError:
        raise _wrong(store, "zarr is not installed: pip install stiefel[xarray]") from None
    if isinstance(store, (str, os.PathLike)):
        path = Path(store)
        if path.is_dir() and any(path.iterdir()) and not any((path / name).exists() for name in (".zgroup", "zarr.json")):
            raise _wrong(store, "is a folder with something else in it: must be empty or the store of this sweep")
        store = str(path)
    try:
        return zarr.open_group(store, mode="a")
    except Exception as error:  # each kind of store raises its own exceptions
        raise _wrong(store, f"cannot be opened: {type(error).__name__}: {error}") from error


def _differences(found: Any, identity: Mapping[str, Any]) -> list[str]:
    found = found if isinstance(found, Mapping) else {}
    parts = [name for name in identity if json.dumps(found.get(name), sort_keys=True) != json.dumps(identity[name], sort_keys=True)]
    return parts or ["its parts"]


def _wrong(store: Any, rule: str) -> InvalidArgument:
    return InvalidArgument(f"store: {store}: {rule}", (Violation("store", f"{store}: {rule}"),))


def open_store(store: Optional[Any], plan: Plan) -> Optional[Store]:
    return None if store is None else Store(store, plan)
