"""Samples of a session: at steps, and at any times, between two steps and on both sides of time 0."""
from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from stiefel._given.instants import seconds_of
from stiefel._given.numbers import refused, step_index
from stiefel._given.when import every_of, in_steps, time_of
from stiefel._wire import answers
from stiefel._wire.sampling import Collector
from stiefel._wire.streams import progress_bar
from stiefel._wire.summarizing import in_given_order, states_at
from stiefel.errors import FailedPrecondition, StiefelError
from stiefel.results import EstimatedError, EstimatedErrors, Outcome, RunStatus, State, Trajectory


def trajectory(session: Any, to: Optional[int], start: int, every: Optional[int], fields: Sequence[str], progress: bool,
               timeout: Optional[float], times: Any, time: Any) -> Trajectory:
    """Returns the samples that `Session.trajectory` describes, without the estimate of an error."""
    if times is not None:
        for name, value, default in (("to", to, None), ("time", time, None), ("start", start, 0), ("every", every, None)):
            if value != default:
                raise refused(name, f"{value!r}: must be absent where `times` are given")
        return at_times(session, times, fields, progress, timeout)
    if to is None and time is None:
        if not session._resolved().HasField("horizon"):
            raise refused("to", "must be given, or time, or times, because the scene has no horizon")
        time = session._resolved().horizon * np.sign(session._resolved().step)
    if to is None and not session._is_step(time):
        return up_to(session, time, start, every, fields, progress, timeout)
    to, start, _ = session._range(to, start, 1, time)
    every = every_of(every, to - start)
    collector = Collector(max(-(-(to - start) // every), 0) + 1, session._origin(to=to))
    samples = session._samples(to, start, every, fields, timeout)
    try:
        with progress_bar(to - start, progress, " steps") as bar:
            for batch in samples:
                collector.add(batch)
                bar.update(int(batch.step[-1]) - start - bar.n)
    except StiefelError as error:
        error.partial = collector.trajectory(RunStatus(Outcome.CANCELLED, message=error.message),
                                             samples.computed_steps)
        raise
    return collector.trajectory(samples.run_status or RunStatus(Outcome.CANCELLED), samples.computed_steps)


def at_times(session: Any, times: Any, fields: Sequence[str], progress: bool, timeout: Optional[float]) -> Trajectory:
    """Returns the states at times in the order given, as `Session.trajectory` describes them."""
    given = np.atleast_1d(seconds_of("times", times, session.epoch))
    if given.ndim != 1 or not given.size:
        raise refused("times", f"the shape {given.shape}: must be (times), one or more")
    behind = in_steps("times", given, session._resolved().step) < 0
    if not behind.any():
        return on_one_side(session, given, np.arange(given.size), fields, progress, timeout)[0]
    places = [np.flatnonzero(~behind), np.flatnonzero(behind)]
    parts: list[tuple[Trajectory, NDArray[Any]]] = []
    with backwards(session, given, timeout) as back:
        for side, place in zip((session, back), places):
            if place.size:
                parts.append(on_one_side(side, given[place], place, fields, progress, timeout))
    return replace(in_given_order(parts), origin=session._origin(times=given))


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


def on_one_side(session: Any, given: NDArray[Any], places: NDArray[Any], fields: Sequence[str], progress: bool,
                timeout: Optional[float]) -> tuple[Trajectory, NDArray[Any]]:
    """Returns the states at times on the side of 0 to which the scene's step leads, and the places of those that were
    reached. `places`: where the caller has the times in its list."""
    step = session._resolved().step
    steps, order = in_steps("times", given, step), np.argsort(given * np.copysign(1, step), kind="stable")
    first, last = int(np.floor(steps[order[0]])), int(np.ceil(steps[order[-1]]))
    request = session._summarize_request(last, first, max(1, last), times=given[order], fields=fields)
    run = states_at(session._summarizing(request, timeout), places[order], session._origin(times=given), progress)
    return run, np.sort(places[order][:run.samples])


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
