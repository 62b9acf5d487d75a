"""When a state is: at a step, which is a whole number, or at a time in seconds."""
from __future__ import annotations

import math
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._given.instants import seconds_of
from stiefel._given.numbers import refused, step_index

MOST_STEPS = 2.0**53  #: beyond it a double does not tell one step from the next
MOST_SAMPLES = 1000  #: of a trajectory whose caller leaves it to the package how many it gets


def absent_with_times(**given: Any) -> None:
    """Raises InvalidArgument for an argument that is given beside `times`."""
    for name, value in given.items():
        if value is not None:
            raise refused(name, f"{value!r}: must be absent where `times` are given")


def in_steps(path: str, given: NDArray[Any], step: float) -> NDArray[Any]:
    """Returns how many steps of the length `step` after time 0 each time is: a whole number where it is one to rounding, as
    the engine takes it. Raises InvalidArgument that names the first wrong one."""
    with np.errstate(over="ignore"):
        steps = given / step
    for wrong, rule in ((~np.isfinite(steps), "must be finite"),
                        (abs(steps) > MOST_STEPS, f"must be at most {MOST_STEPS:.0e} steps from time 0")):
        if wrong.any():
            k = int(np.argmax(wrong))
            raise refused(path if given.ndim == 0 else f"{path}[{k}]", f"{float(given.ravel()[k])!r}: {rule}")
    whole = np.rint(steps)
    return np.where(abs(steps - whole) <= 3 * 2**-53 * abs(whole), whole, steps)


def time_of(time: Any, step: float, epoch: Optional[str], path: str = "time") -> tuple[float, float]:
    """Returns one time in seconds and in steps."""
    seconds = seconds_of(path, time, epoch)
    if seconds.ndim:
        raise refused(path, f"the shape {seconds.shape}: must be one time; several are the `times` of a trajectory")
    return float(seconds), float(in_steps(path, seconds, step))


def times_of(times: Any, epoch: Optional[str]) -> NDArray[Any]:
    """Returns several times in seconds."""
    seconds = np.atleast_1d(seconds_of("times", times, epoch))
    if seconds.ndim != 1 or not seconds.size:
        raise refused("times", f"the shape {seconds.shape}: must be (times), one or more")
    return seconds


def steps_of(times: Any, step: float, epoch: Optional[str]) -> NDArray[np.int64]:
    """Returns the steps at times, each of which must be a step's."""
    return np.array([step_of("to", None, one, step, None, f"times[{k}]") for k, one in enumerate(times_of(times, epoch))], np.int64)


def step_of(name: str, given: Any, time: Any, step: float, epoch: Optional[str], path: str = "time") -> int:
    """Returns the step that the caller gives under `name`, or as a time, which must then be a step's."""
    if time is None:
        if given is None:
            raise refused(name, "must be given, or time")
        return step_index(name, given)
    if given is not None:
        raise refused(name, f"{given!r}: must be absent where `time` is given")
    seconds, steps = time_of(time, step, epoch, path)
    if steps < 0:
        raise refused(path, f"{seconds!r}: must be 0 or have the sign of the scene's step {step!r}; `times` of a trajectory "
                              "may be on both sides of 0")
    if steps != round(steps):
        raise refused(path, f"{seconds!r}: must be a whole number of steps of {step!r} s; the states next to it are at "
                              f"{math.floor(steps) * step!r} and {math.ceil(steps) * step!r}. Session.step and "
                              "Session.trajectory take any time")
    return int(steps)


def every_of(every: Any, steps: int) -> int:
    """Returns the steps between two samples; for None what makes about MOST_SAMPLES samples."""
    return max(1, -(-steps // MOST_SAMPLES)) if every is None else step_index("every", every, 1)
