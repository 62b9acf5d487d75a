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


def time_of(time: Any, step: float, epoch: Optional[str]) -> tuple[float, float]:
    """Returns one time in seconds and in steps."""
    seconds = seconds_of("time", time, epoch)
    if seconds.ndim:
        raise refused("time", f"the shape {seconds.shape}: must be one time; several are the `times` of a trajectory")
    return float(seconds), float(in_steps("time", seconds, step))


def step_of(name: str, given: Any, time: Any, step: float, epoch: Optional[str]) -> int:
    """Returns the step that the caller gives under `name`, or as a time, which must then be a step's."""
    if time is None:
        if given is None:
            raise refused(name, "must be given, or time")
        return step_index(name, given)
    if given is not None:
        raise refused(name, f"{given!r}: must be absent where `time` is given")
    seconds, steps = time_of(time, step, epoch)
    if steps < 0:
        raise refused("time", f"{seconds!r}: must be 0 or have the sign of the scene's step {step!r}; `times` of a trajectory "
                              "may be on both sides of 0")
    if steps != round(steps):
        raise refused("time", f"{seconds!r}: must be a whole number of steps of {step!r} s; the states next to it are at "
                              f"{math.floor(steps) * step!r} and {math.ceil(steps) * step!r}. Session.step and "
                              "Session.trajectory take any time")
    return int(steps)


def every_of(every: Any, steps: int) -> int:
    """Returns the steps between two samples; for None what makes about MOST_SAMPLES samples."""
    return max(1, -(-steps // MOST_SAMPLES)) if every is None else step_index("every", every, 1)
