"""Samples of a session: at steps, and at any times, between two steps and on both sides of time 0."""
from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.instants import seconds_of
from stiefel._given.numbers import refused, step_index
from stiefel._given.when import absent_with_times, every_of, in_steps, time_of, times_of
from stiefel._results.base import Named, joined
from stiefel._wire.arrays import blocks_of
from stiefel._wire.streams import gathered
from stiefel.errors import FailedPrecondition, StiefelError
from stiefel.results import EstimatedErrors, State, Trajectory


def trajectory(session: Any, to: Optional[int], start: int, every: Optional[int], fields: Sequence[str], progress: bool,
               timeout: Optional[float], times: Any, time: Any) -> Trajectory:
    """Returns the samples that `Session.trajectory` describes, without the estimate of an error."""
    scene = session._resolved()
    if times is not None:
        absent_with_times(to=to, time=time, start=start or None, every=every)
        return at_times(session, times, fields, progress, timeout)
    if to is None and time is None:
        if not scene.HasField("horizon"):
            raise refused("to", "must be given, or time, or times, because the scene has no horizon")
        time = scene.horizon * np.sign(scene.step)
    if to is None and not session._is_step(time):  # the time is the last sample
        seconds, steps = time_of(time, scene.step, session.epoch)
        last, start = int(np.floor(steps)), step_index("start", start)
        if steps < start:
            raise refused("time", f"{seconds!r}: must be at or after step {start}, in the direction of the scene's step {scene.step!r}; "
                                  "`times` may be on both sides of 0")
        grid = np.arange(start, last + 1, every_of(every, last - start)) * scene.step
        return at_times(session, np.append(grid, seconds), fields, progress, timeout)
    to, start, _ = session._range(to, start, 1, time)
    every = every_of(every, to - start)
    return gathered(session._samples(to, start, every, fields, timeout), max(-(-(to - start) // every), 0) + 1,
                    session._origin(to=to), progress)


def at_times(session: Any, times: Any, fields: Sequence[str], progress: bool, timeout: Optional[float]) -> Trajectory:
    """Returns the states at times in the order given, as `Session.trajectory` describes them. An exception has in `partial` those
    of one side of time 0 that had arrived, and names times by their index in the list."""
    given = times_of(times, session.epoch)
    behind = in_steps("times", given, session._resolved().step) < 0
    runs, places = [], []
    with backwards(session, given, behind, timeout) as back:
        for side, sign, here in ((session, 1, ~behind), (back, -1, behind)):
            if not here.any():
                continue
            order = np.flatnonzero(here)[np.argsort(abs(given[here]), kind="stable")]
            steps = in_steps("times", given[order], side._resolved().step)
            first, last = int(np.floor(steps[0])), int(np.ceil(steps[-1]))
            request = side._request(pb.SummarizeRequest, last, first, max(1, last), times=given[order], fields=fields)
            try:
                run = gathered(side._summarizing(request, timeout), order.size, session._origin(times=given), progress)
            except StiefelError as error:
                error._as_given("times", order.tolist())
                if error.partial is not None:
                    error.partial = in_order([error.partial], order)
                raise
            runs.append(replace(run, step=sign * run.step))
            places += order[:run.samples].tolist()
    return in_order(runs, places)


def in_order(runs: Sequence[Trajectory], places: Any) -> Trajectory:
    """Joins runs, whose states have these places in the caller's list."""
    ended = next((run for run in runs if not run.success), runs[0])
    run = joined(runs, run_status=ended.run_status, computed_steps=sum(run.computed_steps for run in runs))
    return Named._slice(run, np.argsort(places[:run.samples], kind="stable"))


def backwards(session: Any, times: NDArray[Any], behind: NDArray[Any], timeout: Optional[float]) -> Any:
    """Returns a session of the states before time 0, where those `times` are that are `behind`; nothing to use if there are none."""
    scene = session._resolved()
    if not behind.any():
        return nullcontext()
    if "Q_prev" in blocks_of(scene):
        k = int(np.argmax(behind))
        raise refused(f"times[{k}]", f"{float(times[k])!r}: must have the sign of the scene's step, because the state 0 of "
                                     "this system is a pair of frames")
    return session.fork(at=0, step=-scene.step, timeout=timeout)


def errors_at(session: Any, times: Any, timeout: Optional[float]) -> EstimatedErrors:
    """Returns the estimated errors at times, as `Session.error_at` describes them."""
    given = np.atleast_1d(seconds_of("times", times, session.epoch))
    if given.ndim != 1:
        raise refused("times", f"the shape {given.shape}: must be (times)")
    signed = in_steps("times", given, session._resolved().step)
    steps = np.copysign(np.ceil(abs(signed)), signed).astype(np.int64)
    with backwards(session, given, steps < 0, timeout) as back:
        found = {step: (back if step < 0 else session).diagnose(to=abs(step), timeout=timeout, estimate_error=True).estimated_error
                 for step in np.unique(steps).tolist()}
    errors = [found[step] for step in steps.tolist()]
    numbers: Any = (np.array([getattr(one, name, None) for one in errors], float)  # None becomes NaN
               for name in ("attitude", "momentum", "angle", "reference_error"))
    words: Any = (next((text for one in errors if (text := getattr(one, name, ""))), "") for name in ("reference", "missing"))
    return EstimatedErrors(given, steps, *numbers, *words)


def between_steps(session: Any, time: Any, fields: Sequence[str], timeout: Optional[float]) -> State:
    """Returns the state at one time, as `Session.step` describes it."""
    seconds = time_of(time, session._resolved().step, session.epoch)[0]
    run = at_times(session, [seconds], fields, False, timeout)
    if not run.step.size:
        raise FailedPrecondition(f"time {time!r} cannot be reached: {run.run_status.message}")
    return replace(run[0], computed_steps=run.computed_steps)._of(run._side)
