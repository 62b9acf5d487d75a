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
from stiefel._given.when import every_of, in_steps, time_of
from stiefel._wire import answers
from stiefel._wire.sampling import gathered
from stiefel.errors import FailedPrecondition, StiefelError
from stiefel.results import EstimatedError, EstimatedErrors, Outcome, State, Trajectory


def absent_with_times(**given: Any) -> None:
    """Raises InvalidArgument for an argument that is given beside `times`."""
    for name, value in given.items():
        if value is not None:
            raise refused(name, f"{value!r}: must be absent where `times` are given")


def trajectory(session: Any, to: Optional[int], start: int, every: Optional[int], fields: Sequence[str], progress: bool,
               timeout: Optional[float], times: Any, time: Any) -> Trajectory:
    """Returns the samples that `Session.trajectory` describes, without the estimate of an error."""
    if times is not None:
        absent_with_times(to=to, time=time, start=start or None, every=every)
        return at_times(session, times, fields, progress, timeout)
    if to is None and time is None:
        if not session._resolved().HasField("horizon"):
            raise refused("to", "must be given, or time, or times, because the scene has no horizon")
        time = session._resolved().horizon * np.sign(session._resolved().step)
    if to is None and not session._is_step(time):
        return up_to(session, time, start, every, fields, progress, timeout)
    to, start, _ = session._range(to, start, 1, time)
    every = every_of(every, to - start)
    return gathered(session._samples(to, start, every, fields, timeout), max(-(-(to - start) // every), 0) + 1,
                    session._origin(to=to), progress)


def at_times(session: Any, times: Any, fields: Sequence[str], progress: bool, timeout: Optional[float]) -> Trajectory:
    """Returns the states at times in the order given, as `Session.trajectory` describes them. An exception has in `partial` those
    of one side of time 0 that had arrived, and names times by their index in the list."""
    given = np.atleast_1d(seconds_of("times", times, session.epoch))
    if given.ndim != 1 or not given.size:
        raise refused("times", f"the shape {given.shape}: must be (times), one or more")
    behind = in_steps("times", given, session._resolved().step) < 0
    parts: list[tuple[Trajectory, NDArray[Any]]] = []
    with backwards(session, given, timeout) if behind.any() else nullcontext(session) as back:
        for side, sign, places in ((session, 1, np.flatnonzero(~behind)), (back, -1, np.flatnonzero(behind))):
            if not places.size:
                continue
            step = side._resolved().step
            order = places[np.argsort(given[places] * np.copysign(1, step), kind="stable")]
            steps = in_steps("times", given[order], step)
            first, last = int(np.floor(steps[0])), int(np.ceil(steps[-1]))
            request = side._request(pb.SummarizeRequest, last, first, max(1, last), times=given[order], fields=fields)
            try:
                run = gathered(side._summarizing(request, timeout), order.size, session._origin(times=given), progress)
            except StiefelError as error:
                error._as_given("times", order.tolist())
                if error.partial is not None:
                    error.partial = in_given_order([(error.partial, order)])
                raise
            parts.append((replace(run, step=sign * run.step), order))
    return in_given_order(parts)


def in_given_order(parts: Sequence[tuple[Trajectory, NDArray[Any]]]) -> Trajectory:
    """Joins runs, each of which comes with the places of its states in the caller's list."""
    runs = [run for run, _ in parts]
    order = np.argsort(np.concatenate([places[:run.samples] for run, places in parts]), kind="stable")
    status = next((run.run_status for run in runs if run.run_status.outcome is not Outcome.REACHED), runs[0].run_status)
    return replace(
        runs[0], step=np.concatenate([run.step for run in runs])[order],
        time=np.concatenate([run.time for run in runs])[order], run_status=status,
        fields={name: np.concatenate([run.fields[name] for run in runs])[order] for name in runs[0].fields},
        computed_steps=sum(run.computed_steps for run in runs))


def up_to(session: Any, time: Any, start: int, every: Optional[int], fields: Sequence[str], progress: bool,
          timeout: Optional[float]) -> Trajectory:
    """Returns the samples from `start` up to a time between two steps, which is the last sample."""
    step = session._resolved().step
    seconds, steps = time_of(time, step, session.epoch)
    start = step_index("start", start)
    if steps < start:
        raise refused("time", f"{seconds!r}: must be at or after step {start}, in the direction of the scene's step {step!r}; "
                              "`times` may be on both sides of 0")
    last = int(np.floor(steps))
    grid = np.arange(start, last + 1, every_of(every, last - start)) * step
    return at_times(session, np.append(grid, seconds), fields, progress, timeout)


def backwards(session: Any, times: NDArray[Any], timeout: Optional[float]) -> Any:
    """Returns a session of the states before time 0, at which some of the times are."""
    step = session._resolved().step
    if "Q_prev" in session._blocks():
        k = int(np.argmax(times * np.sign(step) < 0))
        raise refused(f"times[{k}]", f"{float(times[k])!r}: must have the sign of the scene's step, because the state 0 of "
                                     "this system is a pair of frames")
    return session.fork(at=0, step=-step, timeout=timeout)


def errors_at(session: Any, times: Any, timeout: Optional[float]) -> EstimatedErrors:
    """Returns the estimated errors at times, as `Session.error_at` describes them."""
    given = np.atleast_1d(seconds_of("times", times, session.epoch))
    if given.ndim != 1:
        raise refused("times", f"the shape {given.shape}: must be (times)")
    signed = in_steps("times", given, session._resolved().step)
    steps = np.copysign(np.ceil(abs(signed)), signed).astype(np.int64)
    found: dict[int, Optional[EstimatedError]] = {}
    with backwards(session, given, timeout) if (steps < 0).any() else nullcontext(session) as back:
        for step in np.unique(steps).tolist():
            side = back if step < 0 else session
            found[step] = side.diagnose(to=abs(step), timeout=timeout, estimate_error=True).estimated_error
    return answers.errors(given, steps, [found[step] for step in steps.tolist()])


def between_steps(session: Any, time: Any, fields: Sequence[str], timeout: Optional[float]) -> State:
    """Returns the state at one time, as `Session.step` describes it."""
    seconds = time_of(time, session._resolved().step, session.epoch)[0]
    run = at_times(session, [seconds], fields, False, timeout)
    if not run.step.size:
        raise FailedPrecondition(f"time {time!r} cannot be reached: {run.run_status.message}")
    return replace(run[0], computed_steps=run.computed_steps)._of(run._side)
