"""What a sweep returns: one array per statistic over all points, as an xarray.Dataset if xarray is installed."""
from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import ByValue
from stiefel._sweep.axes import Axes
from stiefel._sweep.fold import SAMPLES, over_points
from stiefel._sweep.reduction import OUTCOME, Reduced

Variable = tuple[tuple[str, ...], NDArray[Any]]  # names of the dimensions, values


@dataclass(frozen=True, eq=False, repr=False)
class SweepResult(ByValue, Mapping[str, NDArray[Any]]):
    """The result of a sweep without xarray: `result["energy.drift"]` is an array over the points.

    "outcome" has the numbers of `Outcome` on the wire, with the names in attrs["outcomes"]; 0 means not computed.
    """

    coords: dict[str, Variable]  #: the values of the axes, with the names of their dimensions
    variables: dict[str, Variable]  #: the statistics, "outcome" and "last_step", with the names of their dimensions
    attrs: dict[str, Any] = field(compare=False)

    def __getitem__(self, name: str) -> NDArray[Any]:
        for part in (self.variables, self.coords):
            if name in part:
                return part[name][1]
        raise KeyError(f"no {name!r}; there are {', '.join((*self.variables, *self.coords))}")

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __len__(self) -> int:
        return len(self.variables)

    def to_xarray(self) -> Any:
        """Returns the same content as an xarray.Dataset."""
        import xarray

        return xarray.Dataset(dict(self.variables), dict(self.coords), self.attrs)

    def _as_table(self) -> Any:
        return (f"sweep over {', '.join(self.coords)}", ("variable", "dimensions", "shape"),
                [(name, ", ".join(dims), str(values.shape)) for name, (dims, values) in self.variables.items()])

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {values.shape}" for name, (_, values) in self.variables.items())
        return f"<stiefel.SweepResult: {shapes}>"


class Table:
    """Collects the statistics of finished points in arrays that are allocated once."""

    def __init__(self, axes: Axes, request: pb.SummarizeRequest):
        self._axes = axes
        self._request = request
        self.arrays: dict[str, NDArray[Any]] = {}

    def put(self, points: NDArray[np.int64], arrays: Mapping[str, NDArray[Any]]) -> None:
        for name, values in arrays.items():
            if name not in self.arrays:
                empty = np.nan if values.dtype.kind in "fc" else 0
                self.arrays[name] = np.full((self._axes.points, *values.shape[1:]), empty, values.dtype)
            self.arrays[name][points] = values

    def result(self, attrs: Mapping[str, Any], also: Mapping[str, NDArray[Any]] = MappingProxyType({})) -> SweepResult:
        """Returns the result. Adds the SHA-256 of all arrays to `attrs`. `also`: further variables over all points. The
        number of samples, which follows from `last_step`, is not in the result."""
        dims, shape = self._axes.dims, self._axes.shape
        variables: dict[str, Variable] = {}
        folded = over_points(self._request, self.arrays, self.arrays[OUTCOME] != 0) if self.arrays else {}
        for name, values in sorted({**self.arrays, **also}.items()):
            if name == SAMPLES:
                continue
            if name in folded:
                variables[name] = (_inner_dims(name, folded[name].ndim), folded[name])
                continue
            variables[name] = ((*dims, *_inner_dims(name, values.ndim - 1)), values.reshape(*shape, *values.shape[1:]))
        coords = {axis.path: ((dims[0 if self._axes.zipped else k], *_inner_dims(axis.path, axis.values.ndim - 1)), axis.values)
                  for k, axis in enumerate(self._axes.axes)}
        codes = {name[len("OUTCOME_"):]: number for name, number in pb.Outcome.items()}
        return SweepResult(coords, variables, {**attrs, "outcomes": json.dumps(codes), "sha256": sha256(coords, variables)})


def canonical(reduced: Reduced) -> dict[str, NDArray[Any]]:
    """Returns the arrays in one form: little-endian, every NaN with the same bits, outcomes as bytes."""
    result = {}
    for name, values in reduced.arrays.items():
        if name == OUTCOME:
            values = values.astype("u1")
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
