"""What a file says of a trajectory beside its arrays: scene, build, how to run it again, and how it ended."""
from __future__ import annotations

import dataclasses
import json
import math
from typing import Any, Mapping, Optional

import numpy as np

from stiefel._results.base import Outcome, RunStatus
from stiefel._results.kinds import kind_of
from stiefel._results.estimate import EstimatedError

FORMAT = "stiefel.trajectory"
KEY = "stiefel"  #: the name of this description where a format keeps it beside the arrays
Trajectory = Any  # a `stiefel.Trajectory`


def beginning(run: Trajectory) -> dict[str, Any]:
    """Returns what is known before the first sample: what `stiefel rerun` needs, and the fields."""
    described: dict[str, Any] = {"format": FORMAT}
    if run.origin is not None:
        described.update(numerics_id=run.build, scene=run.scene, run=asked(run))
    described["fields"] = {name: {"shape": list(values.shape[1:]), "dtype": values.dtype.newbyteorder("<").str}
                           for name, values in run.fields.items()}
    described["units"] = {name: run.units[name] for name in ("time", *run.fields) if name in run.units}
    return described


def ending(run: Trajectory) -> dict[str, Any]:
    """Returns how the run ended, and its estimated error if there is one."""
    status = run.run_status
    described: dict[str, Any] = {"outcome": status.outcome.value}
    if status.outcome is not Outcome.REACHED:
        known = {"largest_step": status.largest_step, "member": status.member}
        described.update({name: value for name, value in known.items() if value is not None and math.isfinite(value)})
        described["message"] = status.message
    if run.estimated_error is not None:
        values = dataclasses.asdict(run.estimated_error).items()
        described["estimated_error"] = {name: value for name, value in values if value not in (None, "")}
    return described


def asked(run: Trajectory) -> dict[str, Any]:
    """Returns the arguments of `Session.trajectory` that give the samples again."""
    step, time, origin, fields = run.step, run.time, run.origin, list(run.fields)
    stopped = run.outcome is not Outcome.REACHED
    if not len(run):
        return {"times": [], "fields": fields}
    if (time != step * origin.scene.step).any() or not _even(step):
        times = origin.times if stopped and origin.times is not None else time
        return {"times": np.asarray(times, float).tolist(), "fields": fields}
    every = int(step[1] - step[0]) if len(step) > 1 else 1
    to = int(step[-1]) if not stopped or origin.to is None else origin.to
    return {"to": to, "start": int(step[0]), "every": every, "fields": fields}


def _even(step: Any) -> bool:
    """Returns whether the steps lie evenly, the last one perhaps nearer, as those of a stream do."""
    apart = np.diff(step)
    return bool(step[0] >= 0 and (apart > 0).all() and (apart[:-1] == apart[:1]).all() and (apart[-1:] <= apart[:1]).all())


def run_status(described: Mapping[str, Any]) -> RunStatus:
    return RunStatus(Outcome(described["outcome"]), described.get("largest_step"), described.get("message", ""),
                     described.get("member"))


def estimated_error(described: Mapping[str, Any]) -> Optional[EstimatedError]:
    found = described.get("estimated_error")
    if found is None:
        return None
    names = [field.name for field in dataclasses.fields(EstimatedError)]
    texts: dict[str, str] = dict.fromkeys(("reference", "missing"), "")
    return EstimatedError(**{name: found.get(name, texts.get(name)) for name in names})


def compact(described: Mapping[str, Any]) -> str:
    """Returns the description as JSON on one line."""
    return json.dumps(described, separators=(", ", ": "))


def unit_of(run: Trajectory, field: str) -> str:
    return str(run.units.get(field, ""))


def columns(field: str, values: Any) -> list[str]:
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


def flat(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the samples of fields as columns, one for each number."""
    found: dict[str, Any] = {}
    for field, values in fields.items():
        rows = np.ascontiguousarray(values).reshape(len(values), math.prod(values.shape[1:]))
        found.update(zip(columns(field, values), rows.view(np.real(rows).dtype).T))
    return found


def table(run: Trajectory) -> dict[str, Any]:
    """Returns the samples as columns: step, time, one for each number of each field, and utc where that is known."""
    found = {"step": run.step, "time": run.time, **flat(run.fields)}
    return found if run.utc is None else {**found, "utc": run.utc}


def from_table(read: Any, described: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the fields of a table. `read`: returns the numbers of all columns but step and time as (samples, columns)."""
    fields, begin = {}, 0
    for name, field in described["fields"].items():
        dtype, shape = np.dtype(field["dtype"]), tuple(field["shape"])
        count = math.prod(shape) * (2 if dtype.kind == "c" else 1)
        real = np.dtype(f"<f{dtype.itemsize // (2 if dtype.kind == 'c' else 1)}")
        part = np.ascontiguousarray(read[:, begin:begin + count], real)
        fields[name] = part.view(dtype).reshape(len(read), *shape)
        begin += count
    return fields
