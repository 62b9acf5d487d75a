"""Trajectories as an xarray.Dataset and as a pandas.DataFrame."""
from __future__ import annotations

from typing import Any

import numpy as np

from stiefel._results import about
from stiefel._results.extras import imported
from stiefel._results.kinds import kind_of

Trajectory = Any  # a `stiefel.Trajectory`


def to_xarray(run: Trajectory) -> Any:
    xarray = imported("xarray", "xarray")
    coords: dict[str, Any] = {"time": ("time", run.time, {"units": "s"}), "step": ("time", run.step)}
    variables = {}
    for name, values in run.fields.items():
        kind = kind_of(name)
        is_ensemble = values.ndim == kind.axes + 2
        dims = ["time"] + ["member"] * is_ensemble + _own_dims(name, kind.axes)
        for dim in dims:
            if dim in _COMPONENTS:
                coords[dim] = (dim, list(_COMPONENTS[dim]))
        unit = about.unit_of(run, name)
        variables[name] = (dims, values, {"units": unit} if unit else {})
    described = {**about.beginning(run), **about.ending(run)}
    attrs = {about.KEY: about.compact(described), "outcome": run.outcome.value}
    if run.epoch is not None:
        attrs["epoch"] = run.epoch
    return xarray.Dataset(variables, coords, attrs)


_COMPONENTS = {"component": "wxyz", "axis": "xyz"}


def _own_dims(name: str, axes: int) -> list[str]:
    if name == "quaternion":
        return ["component"]
    if axes == 1:
        return ["axis"] if kind_of(name).columns else [f"{name}_entry"]
    return [f"{name}_row", f"{name}_col"] if axes == 2 else []


def to_dataframe(run: Trajectory) -> Any:
    pandas = imported("pandas", "pandas")
    columns = {name: np.ascontiguousarray(values) for name, values in about.table(run).items()}
    try:
        frame = pandas.DataFrame(columns).set_index("time")
    except pandas.errors.OutOfBoundsDatetime:  # before version 2 pandas counts nanoseconds, up to the year 2262
        frame = pandas.DataFrame({**columns, "utc": np.datetime_as_string(run.utc)}).set_index("time")
    units = {name: about.unit_of(run, field) for field, values in run.fields.items()
             for name in about.columns(field, values)}
    frame.attrs.update({"units": {"time": "s", **{name: unit for name, unit in units.items() if unit}},
                        about.KEY: {**about.beginning(run), **about.ending(run)}})
    return frame
