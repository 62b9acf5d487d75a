"""What is finished of a sweep: its arrays, the Dataset that they make, and the folder that keeps them."""
from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any, Iterable, Iterator, Mapping, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.numbers import refused
from stiefel._results.extras import imported
from stiefel._results.save import complete
from stiefel._sweep.axes import Axes

Variable = tuple[tuple[str, ...], NDArray[Any]]  # names of the dimensions, values


class Table:
    """Collects the statistics of finished points in arrays that are allocated once."""

    def __init__(self, axes: Axes):
        self._axes = axes
        self._arrays: dict[str, NDArray[Any]] = {}

    def put(self, points: NDArray[np.int64], arrays: Mapping[str, NDArray[Any]]) -> None:
        for name, values in arrays.items():
            if name not in self._arrays:
                empty = np.nan if values.dtype.kind in "fc" else 0
                self._arrays[name] = np.full((self._axes.points, *values.shape[1:]), empty, values.dtype)
            self._arrays[name][points] = values

    def dataset(self, attrs: Mapping[str, Any], failures: Mapping[str, int]) -> Any:
        """Returns the Dataset. "outcome" has the numbers of `Outcome` on the wire, 0 where a point was not computed."""
        dims, shape = self._axes.dims, self._axes.shape
        variables: dict[str, Variable] = {
            name: ((*dims, *_inner_dims(name, values.ndim - 1)), values.reshape(*shape, *values.shape[1:]))
            for name, values in sorted(self._arrays.items())}
        coords: dict[str, Variable] = {
            axis.path: ((dims[0 if self._axes.zipped else k], *_inner_dims(axis.path, axis.values.ndim - 1)), axis.values)
            for k, axis in enumerate(self._axes.axes)}
        codes = {name[len("OUTCOME_"):]: number for name, number in pb.Outcome.items()}
        return imported("xarray", "xarray").Dataset(variables, coords, {
            **attrs, "failures": json.dumps(failures), "outcomes": json.dumps(codes), "sha256": sha256(coords, variables)})


def canonical(arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Returns the arrays in one form: little-endian, every NaN with the same bits."""
    result = {}
    for name, values in arrays.items():
        values = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
        if values.dtype.kind in "fc":
            nan = np.isnan(values.view(np.real(values).dtype))
            if nan.any():
                values = values.copy()  # arrays from a worker may be read-only
                values.view(np.real(values).dtype)[nan] = np.nan
        result[name] = values
    return result


def sha256(*parts: Mapping[str, Variable]) -> str:
    """Returns the SHA-256 of name, type, shape and row-major little-endian bytes of each array, sorted by name."""
    digest = hashlib.sha256()
    for part in parts:
        for name in sorted(part):
            values = np.ascontiguousarray(part[name][1])
            digest.update(f"{name} {values.dtype.str} {values.shape}\n".encode())
            digest.update(values.data.cast("B") if values.size and values.dtype.kind != "U" else values.tobytes())
    return digest.hexdigest()


def _inner_dims(name: str, count: int) -> tuple[str, ...]:
    """Returns the names of the dimensions behind the points: rows and columns of a field, or the numbers of a list or
    of a family of invariants, followed by the quantiles or the bins of a histogram."""
    owner, _, statistic = name.rpartition(".")
    if statistic in ("quantiles", "histogram"):
        return (*_inner_dims(f"{owner}.last", count - 1), name.replace(".", "_"))
    if f"STATISTIC_{statistic.upper()}" in pb.Statistic.keys():
        name = owner
    return {0: (), 1: (f"{name}_entry",), 2: (f"{name}_row", f"{name}_col")}[count]


class Store:
    """The folder of one sweep, which sweep.json describes; each finished chunk is a file of arrays. Only the process that
    called `sweep` writes. A file gets its name when it is complete; a damaged one is computed again. Raises InvalidArgument
    if the folder holds another sweep or something else."""

    def __init__(self, folder: "Union[str, os.PathLike[str]]", identity: Mapping[str, Any]):
        self._folder = Path(folder)
        made, text = self._folder / "sweep.json", json.dumps(identity)
        rule = "must be an empty folder or the store of this sweep"
        if made.is_file():
            found = json.loads(made.read_text(encoding="utf-8"))
            wrong = [name for name, part in json.loads(text).items() if found.get(name) != part]
            if wrong:
                raise refused("store", f"{folder}: is the store of another sweep: {', '.join(wrong)} differ; {rule}")
        elif self._folder.exists() and (not self._folder.is_dir() or any(
                one.suffix != ".part" for one in self._folder.iterdir())):
            raise refused("store", f"{folder}: is something else: {rule}")
        else:
            self._folder.mkdir(parents=True, exist_ok=True)
            with complete(made) as part:
                Path(part).write_text(text, encoding="utf-8")

    def finished(self, chunks: Iterable[int]) -> Iterator[tuple[int, dict[str, NDArray[Any]]]]:
        """Yields those chunks that are finished, with their arrays."""
        for chunk in chunks:
            try:
                with np.load(self._folder / f"{chunk}.npz", allow_pickle=False) as file:
                    arrays = {name: file[name] for name in file.files}
            except Exception:  # no such file, or one that is damaged, for which zip and numpy have many exceptions
                continue
            yield chunk, arrays

    def put(self, chunk: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        savez: Any = np.savez
        with complete(self._folder / f"{chunk}.npz") as part, open(part, "wb") as file:
            savez(file, **arrays)
