"""What a file says of a trajectory beside its arrays: scene, build, how to run it again, and how it ended."""
from __future__ import annotations

import dataclasses
import json
import math
from typing import Any, Mapping

import numpy as np

from stiefel._results.base import Outcome, RunStatus

FORMAT = "stiefel.trajectory"
KEY = "stiefel"  #: the name of this description where a format keeps it beside the arrays
Trajectory = Any  # a `stiefel.Trajectory`


def described(run: Trajectory) -> dict[str, Any]:
    """Returns the description of a run: what `stiefel rerun` needs, the fields, how the run ended, and its estimated error."""
    found: dict[str, Any] = {"outcome": run.outcome.value}
    if not run.success:
        known = {name: getattr(run.run_status, name) for name in ("largest_step", "member", "message")}
        found.update({name: value for name, value in known.items() if value not in (None, math.inf)})
    if run.estimated_error is not None:
        found["estimated_error"] = dataclasses.asdict(run.estimated_error)
    found["format"] = FORMAT
    if run.origin is not None:
        found.update(numerics_id=run.build, side=run.origin.side, scene=run.scene, run=asked(run))
    found["fields"] = {name: {"shape": list(values.shape[1:]), "dtype": values.dtype.newbyteorder("<").str}
                       for name, values in run.fields.items()}
    return {**found, "units": run.units}


def compact(run: Trajectory) -> str:
    """Returns the description as JSON on one line."""
    return json.dumps(described(run), separators=(", ", ": "))


def asked(run: Trajectory) -> dict[str, Any]:
    """Returns the arguments of `Session.trajectory` that give the samples again."""
    step, time, origin, fields = run.step, run.time, run.origin, list(run.fields)
    if not len(run):
        return {"times": [], "fields": fields}
    if (time != step * origin._message.step).any() or not _even(step):
        times = time if run.success or origin.times is None else origin.times
        return {"times": np.asarray(times, float).tolist(), "fields": fields}
    every = int(step[1] - step[0]) if len(step) > 1 else 1
    to = int(step[-1]) if run.success or origin.to is None else origin.to
    return {"to": to, "start": int(step[0]), "every": every, "fields": fields}


def _even(step: Any) -> bool:
    """Returns whether the steps lie evenly, the last one perhaps nearer, as those of a stream do."""
    apart = np.diff(step)
    return bool(step[0] >= 0 and (apart > 0).all() and (apart[:-1] == apart[:1]).all() and (apart[-1:] <= apart[:1]).all())


def run_status(found: Mapping[str, Any]) -> RunStatus:
    return RunStatus(Outcome(found["outcome"]), found.get("largest_step"), found.get("message", ""), found.get("member"))
