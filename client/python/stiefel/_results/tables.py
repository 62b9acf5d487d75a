"""Samples as columns of numbers, as an xarray.Dataset and as a pandas.DataFrame."""
from __future__ import annotations

import math
from typing import Any, Mapping

import numpy as np

from stiefel._results import about
from stiefel._results.base import Array
from stiefel._results.extras import imported
from stiefel._results.kinds import kind_of

Trajectory = Any  # a `stiefel.Trajectory`


def columns(field: str, values: Array) -> list[str]:
    """Returns the names of a field's numbers in a table: "q_w", "q[0]", "epsilon" or "Q[0,0]", of a member "q_w[2]",
    "q[2][0]", "epsilon[2]" or "Q[2][0,0]". A complex number has a column for its real and one for its imaginary part."""
    kind = kind_of(field)
    parts = ("Re ", "Im ") if np.iscomplexobj(values) else ("",)
    names = []
    for of_member in [f"[{member}]" for member in range(values.shape[1])] if values.ndim == kind.axes + 2 else [""]:
        for index in np.ndindex(values.shape[values.ndim - kind.axes:]):
            at = f"[{','.join(map(str, index))}]" if index else ""
            names.append(kind.columns[index[0]] + of_member if kind.columns else field + of_member + at)
    return [part + name for name in names for part in parts]


def flat(fields: Mapping[str, Array]) -> dict[str, Array]:
    """Returns the samples of fields as columns, one for each number."""
    found: dict[str, Array] = {}
    for field, values in fields.items():
        rows = np.ascontiguousarray(values).reshape(len(values), math.prod(values.shape[1:]))
        found.update(zip(columns(field, values), rows.view(np.real(rows).dtype).T))
    return found


def table(run: Trajectory) -> dict[str, Array]:
    """Returns the samples as columns: step, time, one for each number of each field, and utc where that is known."""
    found = {"step": run.step, "time": run.time, **flat(run.fields)}
    return found if run.utc is None else {**found, "utc": run.utc}


def to_xarray(run: Trajectory) -> Any:
    """Returns an `xarray.Dataset` with the coordinates `time` and `step` and a variable for each field, which has its unit; the
    dataset's attribute `stiefel` says what a file of `save` says."""
    coords: dict[str, Any] = {"time": ("time", run.time, {"units": "s"}), "step": ("time", run.step)}
    variables = {}
    for name, values in run.fields.items():
        axes, names = kind_of(name).axes, kind_of(name).columns
        own = {0: (), 1: ("component" if len(names) == 4 else "axis" if names else f"{name}_entry",), 2: (f"{name}_row", f"{name}_col")}[axes]
        if names:
            coords[own[0]] = (own[0], list("wxyz"[-len(names):]))
        variables[name] = (("time", *["member"] * (values.ndim == axes + 2), *own), values,
                           {"units": run.units[name]} if name in run.units else {})
    attrs = {about.KEY: about.compact(run), "outcome": run.outcome.value, **({} if run.epoch is None else {"epoch": run.epoch})}
    return imported("xarray", "xarray").Dataset(variables, coords, attrs)


def to_dataframe(run: Trajectory) -> Any:
    """Returns a `pandas.DataFrame` with the index `time`, the column `step`, and a column for each number: q_w, omega_x, Q[0,0], ...,
    and `utc` where that is known; `attrs` has units and what a file of `save` says."""
    pandas = imported("pandas", "pandas")
    found = {name: np.ascontiguousarray(values) for name, values in table(run).items()}
    try:
        frame = pandas.DataFrame(found).set_index("time")
    except pandas.errors.OutOfBoundsDatetime:  # before version 2 pandas counts nanoseconds, up to the year 2262
        frame = pandas.DataFrame({**found, "utc": np.datetime_as_string(run.utc)}).set_index("time")
    units = {name: run.units[field] for field, values in run.fields.items() if field in run.units for name in columns(field, values)}
    frame.attrs.update({"units": {"time": "s", **units}, about.KEY: about.described(run)})
    return frame
