"""When a call is made again, and after which pause. A call that found no server and one that the server refused for a
while have attempts of their own, so that a call has at most the sum of both."""
from __future__ import annotations

import random
from typing import Optional

from stiefel.errors import ResourceExhausted, StiefelError, Unavailable

ATTEMPTS = 6  # at a server that is not there
REFUSALS = 64  # by a server that says when to come back


class Pauses:
    """Of one call, in seconds. For a server that is not there: 0.05, 0.1, 0.2 ... in all 1.55 s. For a refusal with a
    delay: that delay and a random time of up to 0.01, 0.02, 0.04 ... 1 s, so that callers refused together do not
    come back together."""

    def __init__(self) -> None:
        self._unavailable = 0
        self._refusals = 0

    def after(self, error: StiefelError) -> Optional[float]:
        """The pause before the next attempt; None if there is to be none."""
        if isinstance(error, Unavailable) and self._unavailable < ATTEMPTS - 1:
            self._unavailable += 1
            return float(0.05 * 2 ** (self._unavailable - 1))
        if isinstance(error, ResourceExhausted) and error.retry_delay is not None and self._refusals < REFUSALS:
            self._refusals += 1
            return error.retry_delay + random.uniform(0, min(0.01 * 2 ** (self._refusals - 1), 1.0))
        return None
