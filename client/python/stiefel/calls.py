"""Deadlines and retries. Every call is idempotent, so a call that found no server is made again."""
from __future__ import annotations

import time
from typing import Any, Callable, Iterator, Optional

import grpc

from stiefel.errors import StiefelError, Unavailable, from_rpc_error

ATTEMPTS = 6


def pauses() -> Iterator[float]:
    """Seconds to wait between attempts: 0.05, 0.1, 0.2, ... in all 1.55 s."""
    return (0.05 * 2**attempt for attempt in range(ATTEMPTS - 1))


def call(method: Callable[..., Any], request: Any, timeout: Optional[float]) -> Any:
    """One unary call: at most `timeout` seconds, retries included."""
    deadline = None if timeout is None else time.monotonic() + timeout
    waits = pauses()
    while True:
        left = None if deadline is None else max(deadline - time.monotonic(), 0.0)
        try:
            return method(request, timeout=left)
        except grpc.RpcError as rpc_error:
            error = from_rpc_error(rpc_error)
        pause_or_raise(error, waits, deadline)


def pause_or_raise(error: StiefelError, waits: Iterator[float], deadline: Optional[float] = None) -> None:
    """Sleeps before the next attempt, or raises `error` if there is to be none."""
    wait = next(waits, None) if isinstance(error, Unavailable) else None
    if wait is None or (deadline is not None and time.monotonic() + wait > deadline):
        raise error from None
    time.sleep(wait)
