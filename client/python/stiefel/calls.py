"""Deadlines and retries. Every call is idempotent, so a call that found no server, or one with no place for it, is made
again."""
from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Callable, Optional

import grpc

from stiefel.errors import DeadlineExceeded, StiefelError
from stiefel.retry import ATTEMPTS, Pauses

if TYPE_CHECKING:
    from stiefel.client import Client

__all__ = ["ATTEMPTS", "Deadline", "call", "pause_or_raise", "pauses"]


def pauses() -> Pauses:
    """The pauses between the attempts of a call that begins now."""
    return Pauses()


class Deadline:
    """The monotonic time at which a call of `timeout` seconds ends; None for no end."""

    def __init__(self, timeout: Optional[float]):
        self.timeout = timeout
        self._end = None if timeout is None else time.monotonic() + timeout

    def left(self) -> Optional[float]:
        """Seconds, at least 0."""
        return None if self._end is None else max(self._end - time.monotonic(), 0.0)

    def comes_within(self, seconds: float) -> bool:
        left = self.left()
        return left is not None and left < seconds


def call(method: Callable[[Optional[float]], Any], client: Client, timeout: Optional[float]) -> Any:
    """One call of `client`: at most `timeout` seconds, retries included. `method` gets the seconds left."""
    deadline, waits = Deadline(timeout), pauses()
    while True:
        try:
            return method(deadline.left())
        except (grpc.RpcError, ValueError) as failure:
            error = client.error(failure)
        pause_or_raise(error, waits, client, deadline)


def pause_or_raise(error: StiefelError, waits: Pauses, client: Client, deadline: Optional[Deadline] = None,
                   late: bool = False) -> None:
    """Waits before the next attempt, or raises `error` if there is to be none; with `late`
    DeadlineExceeded if that is because the deadline comes first."""
    wait = waits.after(error)
    if wait is None:
        raise error from None
    if deadline is not None and deadline.comes_within(wait):
        if late:
            raise DeadlineExceeded(f"no time is left of {deadline.timeout:g} s: {error.message}") from error
        raise error from None
    client.connection.rest(wait)
