"""The attempts of one call. Every call is idempotent, so it is made again while its server is away, after a refusal that
says when to come back, and after the loss of its session.

gRPC's own retry policy does not suffice: it makes five attempts at most, within seconds, and none after the first message of
a stream.
"""
from __future__ import annotations

import random
import sys
import time
from typing import Any, Callable, Optional, TypeVar

import grpc

from stiefel._given.numbers import timeout as checked
from stiefel.errors import DeadlineExceeded, ResourceExhausted, StiefelError, Unavailable

ATTEMPTS = 6  # at a server that was never reached, or has too much at once
REFUSALS = 64  # by a server that says when to come back
LONGEST = 300.0  # seconds; a refusal for longer is raised at once
TOLD_AFTER = 3.0  # seconds for which a server is away, after which stderr is told
T = TypeVar("T")


class Attempts:
    """The attempts of one call and the pauses between them, in seconds. While the server is away, or has lost the session:
    0.05, 0.1, 0.2, 0.4, 0.8, 0.8, ..., six attempts at a server that was never reached, and until the deadline at one that
    was. After a refusal with a delay: that delay and a random time of up to 0.01, 0.02, 0.04 ... 1 s, so that callers
    refused together do not come back together."""

    def __init__(self, connection: Any, timeout: Any, session: Any = None, waits: bool = True, endless: bool = False):
        """`connection`: a Connection. `timeout`: seconds, a timedelta or a quantity of time for all attempts. If it is None, that of the connection
        applies, except with `endless`. `session`: the Recreation that creates its session again if the server has lost it.
        `waits`: whether a server that was reached and went is waited for. Raises InvalidArgument for another timeout."""
        self._connection, self._session = connection, session
        self._waits = waits and connection.waits
        given = checked(timeout)
        self.has_own = given is not None
        self.timeout = connection.timeout if given is None and not endless else given
        self.renew()
        self._restart()

    def renew(self) -> None:
        """Begins to count anew, because the call made progress. A timeout of the connection begins anew too."""
        self._failures = self._refusals = 0
        self._away_since: Optional[float] = None
        self._told = False
        if not self.has_own:
            self._restart()

    def _restart(self) -> None:
        self._end = None if self.timeout is None else time.monotonic() + self.timeout

    def left(self) -> Optional[float]:
        """Returns the seconds that are left, at least 0; None for no end."""
        return None if self._end is None else max(self._end - time.monotonic(), 0.0)

    def run(self, attempt: Callable[[Optional[float]], T]) -> T:
        """Returns what `attempt` returns, which gets the seconds that are left."""
        while True:
            try:
                return attempt(self.left())
            except StiefelError as failure:
                error: StiefelError = failure
            except (grpc.RpcError, ValueError) as failure:
                error = self._connection.error(failure)
            self.again(error)

    def again(self, error: StiefelError) -> None:
        """Waits for the next attempt. Raises `error` if there is none, or if the deadline comes first."""
        away = isinstance(error, Unavailable) or self._session is not None and self._session.is_lost(error)
        wait, left = self._pause(error, away), self.left()
        if wait is None or left is not None and left < wait:
            if isinstance(error, DeadlineExceeded) and self.timeout is not None:
                error._say(f"{error.message} of {self.timeout:.3g} s{error._takes}")
            raise error from None
        self._connection.rest(wait, away)

    def _pause(self, error: StiefelError, away: bool) -> Optional[float]:
        """Returns the seconds before the next attempt; None if there is no further attempt."""
        if away or error._may_pass:
            now = time.monotonic()
            self._away_since = now if self._away_since is None else self._away_since
            waited, patience = now - self._away_since, self._patience()
            if self._failures >= ATTEMPTS - 1 and not (away and (patience is None or waited < patience)):
                return None
            if waited > TOLD_AFTER and not self._told:
                self._told = True
                more = "" if patience is None else f" for up to {patience - waited:.3g} s more"
                print(f"stiefel: {error.message}; waits{more}", file=sys.stderr)
            self._failures += 1
            return float(0.05 * 2 ** min(self._failures - 1, ATTEMPTS - 2))
        delay = error.retry_delay if isinstance(error, ResourceExhausted) else None
        if delay is None or delay > LONGEST or self._refusals >= REFUSALS:
            return None
        self._refusals += 1
        return max(delay, 0.0) + random.uniform(0, min(0.01 * 2 ** (self._refusals - 1), 1.0))

    def _patience(self) -> Optional[float]:
        """Returns the seconds for which a server that went is waited for; None for no end."""
        if not (self._waits and self._connection.reached):
            return 0.0
        return self.timeout if self.timeout is not None else self._connection.timeout
