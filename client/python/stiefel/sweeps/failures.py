"""How a chunk can fail, and what that means for the sweep."""
from __future__ import annotations

from collections import Counter
from concurrent.futures import BrokenExecutor
from typing import Any, Optional

import grpc

from stiefel.errors import InvalidArgument, StiefelError, Violation

ATTEMPTS = 16  #: times that one chunk is given to workers that die
FRUITLESS = 8  #: replacements of a broken pool without a finished chunk between them
# By name, because Dask, Ray and loky may be absent: exceptions that mean a worker died, not that the task is wrong.
_DEAD = {"KilledWorker", "WorkerCrashedError", "NodeDiedError", "RayActorError", "ActorDiedError", "ObjectLostError",
         "OwnerDiedError", "LocalRayletDiedError", "NodePreemptedError", "OutOfMemoryError", "CancelledError",
         "FutureCancelledError", "CommClosedError", "TerminatedWorkerError"}


class LostServer(StiefelError):
    """The server of a worker ended or could not be reached while it computed a chunk."""

    code = grpc.StatusCode.UNAVAILABLE


class OtherNumerics(StiefelError):
    """A worker whose server would compute other bits than the sweep began with."""

    code = grpc.StatusCode.FAILED_PRECONDITION


class SweepFailed(StiefelError):
    """The sweep ended before its last chunk. What is done is in the store, if there is one, and in `partial`."""

    code = grpc.StatusCode.ABORTED
    done: int = 0  #: finished chunks
    chunks: int = 0  #: of so many
    failures: dict[str, int]  #: by the exception's name, how often a chunk failed
    partial: Any = None  #: what `sweep` would have returned; `outcome` is 0 at the points that are missing

    def __init__(self, message: str, done: int = 0, chunks: int = 0, failures: Optional[dict[str, int]] = None):
        super().__init__(message)
        self.done, self.chunks, self.failures = done, chunks, failures or {}

    def __str__(self) -> str:
        return self.message


class Failures:
    """Counts failures, and says when there were too many."""

    def __init__(self) -> None:
        self.counted: Counter[str] = Counter()
        self._chunks: Counter[int] = Counter()

    def may_try_again(self, chunk: int, error: BaseException) -> bool:
        """Whether the chunk may be given again after this error."""
        self.counted[type(error).__name__] += 1
        if not is_dead_worker(error):
            return False
        self._chunks[chunk] += 1
        return self._chunks[chunk] < ATTEMPTS

    def of(self, chunk: int) -> int:
        return self._chunks[chunk]


def at(error: InvalidArgument, where: str) -> InvalidArgument:
    """The error with the points of the sweep that it is about."""
    return InvalidArgument(f"{error.message} ({where})",
                           tuple(Violation(v.field, f"{v.description} ({where})") for v in error.violations), error.reason)


def is_dead_worker(error: BaseException) -> bool:
    """Whether the worker is to blame and another one may do the same task."""
    if isinstance(error, (BrokenExecutor, LostServer, OtherNumerics, ConnectionError)):
        return True
    return any(kind.__name__ in _DEAD for kind in type(error).__mro__)
