"""What a page or a picture shows of a run: drift and estimated error over the whole of it, and samples dense enough to be
drawn."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stiefel._results.base import Array, RunStatus

Session = Any  # a `stiefel.Session`
Trajectory = Any  # a `stiefel.Trajectory`

DRIFTS = 60  #: points of a curve of drifts
ERRORS = 20  #: parts of a curve of errors, between 21 points
DEAREST = 2e9  #: instructions that such a curve may take; where it would take more, it has fewer parts, but at least one
FINEST = 0.1  #: radians between two samples
FEWEST, MOST = 500, 12_000  #: samples
BYTES = 1_100_000  #: of all samples in single precision
LARGEST = 8  #: rows and columns that are shown of a matrix


@dataclass
class Family:
    """A family of invariants, with its largest drift at each time."""

    name: str
    conservation: str
    count: int
    drift: list[float]


@dataclass
class Accuracy:
    """How well a run keeps its invariants, and how far it is from the exact motion."""

    run_status: RunStatus
    step: int  #: the last good one
    horizon: float  #: its time
    speed: float  #: the largest norm of the angular velocity, in radians a unit of time; 0 where there is none
    time: list[float]
    families: list[Family]
    error_time: list[float]
    #: of attitude and momentum; the bound, twice the error of the reference, where an error is too small to tell
    errors: dict[str, list[float]]
    error: Any  #: the `stiefel.EstimatedError` at the last step, or None
    motion: Any  #: the `stiefel.Motion` of one body in three dimensions, or None


def accuracy(session: Session, to: int, estimate_error: bool = True) -> Accuracy:
    """Diagnoses the run up to step `to`. The error is estimated where that takes at most about ten seconds."""
    last = session.diagnose(to=to, estimate_error=estimate_error)
    estimate = last.estimated_error
    # The estimate at step k takes k / last of the work of that at the last: n parts take (n + 1) / 2 of it.
    parts = 0 if estimate is None or not estimate.reference else int(np.clip(2 * DEAREST / max(estimate.work, 1) - 1, 1, ERRORS))
    steps = np.unique(np.linspace(0, last.step, DRIFTS + 1).astype(int)).tolist()
    estimated = {steps[k] for k in np.unique(np.linspace(0, len(steps) - 1, parts + 1).astype(int))} if parts else set()
    out = Accuracy(last.run_status, last.step, last.time, 0, [], [], [], {"attitude": [], "momentum": []},
                   estimate, last.motion)
    families: dict[str, Family] = {}
    for step in steps:
        diagnosis = last if step == last.step else session.diagnose(to=step, estimate_error=step in estimated)
        out.time.append(diagnosis.time)
        out.speed = max(out.speed, diagnosis.domain.h_omega)
        drifts: dict[tuple[str, str], list[float]] = {}
        for one in diagnosis.invariants:
            drifts.setdefault((one.name.partition("[")[0], str(one.conservation)), []).append(one.drift)
        if diagnosis.orthogonality is not None:
            drifts["orthogonality", ""] = [diagnosis.orthogonality]
        for (name, kept), of in drifts.items():
            families.setdefault(name, Family(name, kept, diagnosis.shortened.get(name, len(of)), [])).drift.append(max(of))
        if diagnosis.estimated_error is not None and diagnosis.estimated_error.reference:
            out.error_time.append(diagnosis.time)
            for name, values in out.errors.items():
                value = getattr(diagnosis.estimated_error, name)
                values.append(2 * diagnosis.estimated_error.reference_error if value is None else value)
    out.families = list(families.values())
    scene = session.scene
    out.speed *= scene.get("method", {}).get("substeps", 1) / abs(scene["step"])
    return out


def drawn_fields(session: Session) -> list[str]:
    """Returns the names of the fields that are drawn: the frame, if the scene has one, and a rate."""
    scene = session.scene
    system = next(one for one in session._connection.systems() if one.name == scene["system"])
    names = {one.name for one in system.fields}
    given = {*scene.get("initial", {}), *scene.get("initial_tensors", {})}
    frame = [name for name in ("Q", "q") if name in names and ("body" in scene or name in given)]
    return frame + [name for name in ("Qdot", "M", "P") if name in names][:1]


def samples(session: Session, run: Accuracy) -> Trajectory:
    """Returns samples dense enough to be drawn, from step 0 to the end of the run or as far as their number allows. States
    between steps are computed where the steps are too long; a discrete system has none."""
    scene, fields = session.scene, drawn_fields(session)
    step, end = scene["step"], abs(run.horizon)
    if run.step == 0:
        return session.trajectory(to=0, fields=fields)
    numbers = sum(_drawn_numbers(values[0]) for values in session.trajectory(to=0, fields=fields).fields.values())
    most = min(MOST, BYTES // (4 * numbers))
    finest = FINEST / run.speed if run.speed else 0.0
    shown = min(end, most * finest or end)
    count = int(np.clip(np.ceil(shown / finest) if finest else FEWEST, min(FEWEST, most), most))
    every = shown / count / abs(step)
    if every >= 1 or "method" not in scene:
        to = min(run.step, int(np.ceil(shown / abs(step))))
        return session.trajectory(to=to, every=int(np.ceil(every)), fields=fields)
    return session.trajectory(times=np.linspace(0, np.copysign(shown, step), count + 1), fields=fields)


def _drawn_numbers(values: Array) -> int:
    rows, cols = values.shape[-2:] if values.ndim > 1 else (1, values.size)
    return int(min(rows, LARGEST) * min(cols, LARGEST) * (2 if np.iscomplexobj(values) else 1))
