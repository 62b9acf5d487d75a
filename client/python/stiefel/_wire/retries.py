"""The attempts of one call. Every call is idempotent, so it is made again while its server is away, after a refusal that
says when to come back, and after the loss of its session.

gRPC's own retry policy keeps to the delay of a refusal, but it makes five attempts at most and none after the first message of
a stream, and it hides the checkpoint that a server that stops sends with its error.
"""
from __future__ import annotations

import random
import sys
import time
from typing import Any, Callable, Optional, TypeVar

import grpc

from stiefel._given.numbers import timeout as checked
from stiefel.errors import DeadlineExceeded, StiefelError, Unavailable

ATTEMPTS = 6  # at a server that was never reached, or has too much at once
TOLD_AFTER = 3.0  # seconds of pauses, after which stderr is told
T = TypeVar("T")


class Attempts:
    """The attempts of one call and the pauses between them, in seconds. While the server is away, or has lost the session:
    0, 0.05, 0.15, 0.35, 0.75, 0.75, ..., six attempts at a server that was never reached, and until the deadline at one that
    was. After a refusal with a delay, until the deadline: that delay and a random time of up to 0.01, 0.02, 0.04 ... 1 s, so
    that callers refused together do not come back together."""

    def __init__(self, calls: Any, request: Any, timeout: Any, waits: bool = True, endless: bool = False):
        """`calls`: the Calls of the call. `timeout`: seconds, a timedelta or a quantity of time for all attempts. If it is None,
        that of the connection applies, except with `endless`, where it is for one time without an answer. `waits`: whether a
        server that was reached and went is waited for. Raises InvalidArgument for another timeout."""
        self._calls, self._request = calls, request
        self._connection = calls.connection
        self._waits = waits and self._connection.waits
        self._own = checked(timeout)
        self.timeout = self._connection.timeout if self._own is None and not endless else self._own
        self._end: Optional[float] = None
        self._since = 0.0  # when the first failure since the last progress was seen
        self.renew()

    def renew(self) -> None:
        """Begins to count anew, because the call made progress. A timeout of the connection begins anew too."""
        self._failures = 0
        self._told = False
        if self.timeout is not None and (self._own is None or self._end is None):
            self._end = time.monotonic() + self.timeout

    def left(self) -> Optional[float]:
        """Returns the seconds that are left, at least 0; None for no end."""
        return None if self._end is None else max(self._end - time.monotonic(), 0.0)

    def run(self, attempt: Callable[[Optional[float]], T]) -> T:
        """Returns what `attempt` returns, which gets the seconds that are left."""
        while True:
            try:
                return attempt(self.left())
            except (StiefelError, grpc.RpcError, ValueError) as failure:
                self.again(failure)

    def again(self, failure: Exception) -> None:
        """Waits for the next attempt. Raises the exception for `failure` if there is none, or if the deadline comes first."""
        error = failure if isinstance(failure, StiefelError) else self._calls.error(failure)
        wait, left = self._pause(error), self.left()
        if wait is None or left is not None and left < wait:
            if isinstance(error, DeadlineExceeded) and self.timeout is not None:
                error._say(f"{error.message} of {self.timeout:.3g} s{self._calls.takes(self._request)}")
            raise error from None
        self._connection.rest(wait, isinstance(error, Unavailable))

    def _pause(self, error: StiefelError) -> Optional[float]:
        """Returns the seconds before the next attempt; None if there is no further attempt."""
        if isinstance(error, DeadlineExceeded):
            return 0.0 if self.left() else None  # of a stream that began before the last progress
        away, delay, now = isinstance(error, Unavailable) or self._calls.is_lost(error), error.retry_delay, time.monotonic()
        if not away and not error._may_pass and delay is None:
            return None
        self._since = self._since if self._failures else now
        patient = delay is not None or away and self._waits and self._connection.reached
        patience = self._connection.timeout if self.timeout is None else self.timeout
        if self._failures >= ATTEMPTS - 1 and not (patient and (patience is None or now - self._since < patience)):
            return None
        if now - self._since > TOLD_AFTER and not self._told:
            self._told = True
            more = "" if patience is None else f" for up to {patience + self._since - now:.3g} s more"
            print(f"stiefel: {error.message}; waits{more}", file=sys.stderr)
        self._failures += 1
        if delay is None:
            return float(0.05 * (2 ** min(self._failures - 1, ATTEMPTS - 2) - 1))
        return max(delay, 0.0) + random.uniform(0, min(0.01 * 2 ** (self._failures - 1), 1.0))
