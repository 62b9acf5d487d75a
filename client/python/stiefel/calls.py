"""Deadlines and retries. Every call is idempotent, so that it can be repeated when the server cannot be reached or
refuses it because it is full. The attempts for these two reasons are counted separately."""
from __future__ import annotations

import random
import time
from typing import TYPE_CHECKING, Any, Callable, Optional

import grpc

from stiefel.errors import CorruptReply, DeadlineExceeded, ResourceExhausted, StiefelError, Unavailable
from stiefel.given.numbers import timeout as checked

if TYPE_CHECKING:
    from stiefel.client import Client

ATTEMPTS = 6  # at a server that cannot be reached
REFUSALS = 64  # by a server that says when to come back
WORK_PER_SECOND = 5e9  #: units of work (instructions) that a core does in a second
LONGEST = 300.0  # seconds; a refusal for longer is raised at once


class Pauses:
    """The pauses before the next attempts of one call, in seconds. For a server that cannot be reached: 0.05, 0.1,
    0.2 ..., 1.55 s in all. For a refusal with a delay: that delay and a random time of up to 0.01, 0.02, 0.04 ... 1 s,
    so that callers refused together do not come back together. A refusal for more than 300 s ends the call."""

    def __init__(self) -> None:
        self._unavailable = 0
        self._refusals = 0

    def after(self, error: StiefelError) -> Optional[float]:
        """Returns the pause before the next attempt in seconds; None if there is no further attempt."""
        if isinstance(error, Unavailable) and self._unavailable < ATTEMPTS - 1:
            self._unavailable += 1
            return float(0.05 * 2 ** (self._unavailable - 1))
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


def call(method: Callable[[Optional[float]], Any], client: Client, timeout: Optional[float]) -> Any:
    """Makes one call of `client`, which takes at most `timeout` seconds, retries included. `method` makes one attempt
    and gets the seconds that are left."""
    deadline, waits = Deadline(timeout), Pauses()
    while True:
        try:
            reply = method(deadline.left())
        except (grpc.RpcError, ValueError) as failure:
            error = client.error(failure)
        else:
            if reply is None:
                raise CorruptReply("the server ended the call without a reply")
            return reply
        pause_or_raise(error, waits, client, deadline)


def takes(failure: Any) -> str:
    """How long a failed call takes, as its server told at the beginning; empty if it told nothing."""
    metadata = failure.initial_metadata() if hasattr(failure, "initial_metadata") else None
    for key, value in metadata or ():
        if key == "stiefel-work":
            work = float(value)
            return f"; it takes about {work / WORK_PER_SECOND:.2g} s of one core ({work:.1e} instructions)"
    return ""


def in_time(error: StiefelError, deadline: Optional[Deadline]) -> StiefelError:
    """Returns the error, after it has got the call's timeout if that is over, and how long the call takes."""
    if isinstance(error, DeadlineExceeded) and deadline is not None and deadline.timeout is not None:
        error.say(f"{error.message} of {deadline.timeout:.3g} s{error.takes}")
    return error


def pause_or_raise(error: StiefelError, waits: Pauses, client: Client, deadline: Optional[Deadline] = None,
                   late: bool = False) -> None:
    """Waits before the next attempt, or raises `error` if there is no further attempt. If that is because the deadline
    comes first and `late` is set, raises DeadlineExceeded instead."""
    wait = waits.after(error)
    if wait is None:
        raise in_time(error, deadline) from None
    if deadline is not None and deadline.comes_within(wait):
        if late:
            raise DeadlineExceeded(f"no time is left of {deadline.timeout:g} s: {error.message}") from error
        raise error from None
    client.connection.rest(wait)
