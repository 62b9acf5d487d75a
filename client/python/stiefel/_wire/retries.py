"""Deadlines and pauses between attempts. Every call is idempotent, so that it can be repeated when the server cannot be
reached or refuses it because it is full. The attempts for these two reasons are counted separately."""
from __future__ import annotations

import math
import random
import time
from typing import Any, Optional

from stiefel._given.numbers import timeout as checked
from stiefel.errors import DeadlineExceeded, ResourceExhausted, StiefelError, Unavailable

ATTEMPTS = 6  # at a server that was never reached, or has too much at once
REFUSALS = 64  # by a server that says when to come back
LONGEST = 300.0  # seconds; a refusal for longer is raised at once


class Pauses:
    """The pauses before the next attempts of one call, in seconds. For a server that cannot be reached, or where gRPC
    or a proxy ends calls because of too much at once: 0.05, 0.1, 0.2, 0.4, 0.8 s, and 0.8 s again for as long as the
    caller is patient with a server that went. For a refusal with a delay: that delay and a random time of up to 0.01,
    0.02, 0.04 ... 1 s, so that callers refused together do not come back together. A refusal for more than 300 s ends
    the call."""

    def __init__(self) -> None:
        self._unavailable = 0
        self._refusals = 0
        self.missed = math.inf  #: when the server was first away

    @property
    def away(self) -> float:
        """The seconds since the server was first away."""
        return time.monotonic() - self.missed

    def after(self, error: StiefelError, patience: float = 0.0) -> Optional[float]:
        """Returns the pause before the next attempt in seconds; None if there is no further attempt. `patience`: the
        seconds for which a server that is away is waited for, beyond the first attempts."""
        is_away = isinstance(error, Unavailable)
        if is_away:
            self.missed = min(self.missed, time.monotonic())
        if (is_away or error._may_pass) and self._unavailable < ATTEMPTS - 1 or is_away and self.away < patience:
            self._unavailable += 1
            return float(0.05 * 2 ** min(self._unavailable - 1, ATTEMPTS - 2))
        delay = error.retry_delay if isinstance(error, ResourceExhausted) else None
        if delay is not None and delay <= LONGEST and self._refusals < REFUSALS:
            self._refusals += 1
            return max(delay, 0.0) + random.uniform(0, min(0.01 * 2 ** (self._refusals - 1), 1.0))
        return None


class Deadline:
    """The monotonic time at which a call of `timeout` seconds ends; None for no end."""

    def __init__(self, timeout: Any):
        """`timeout`: seconds, a timedelta or a quantity of time; None for no end. Raises InvalidArgument for others."""
        self.timeout = checked(timeout)
        self._end = None if self.timeout is None else time.monotonic() + self.timeout

    def left(self) -> Optional[float]:
        """Returns the seconds that are left, at least 0; None for no end."""
        return None if self._end is None else max(self._end - time.monotonic(), 0.0)

    def comes_within(self, seconds: float) -> bool:
        left = self.left()
        return left is not None and left < seconds

    def explain(self, error: StiefelError) -> StiefelError:
        """Returns the error, after it has got the call's timeout if that is over, and how long the call takes."""
        if isinstance(error, DeadlineExceeded) and self.timeout is not None:
            error._say(f"{error.message} of {self.timeout:.3g} s{error._takes}")
        return error
