"""The failures of chunks, and whether a chunk may be tried again."""
from __future__ import annotations

from collections import Counter
from concurrent.futures import BrokenExecutor
from typing import Optional

import grpc

from stiefel.errors import InvalidArgument, StiefelError, Violation

ATTEMPTS = 16  #: after so many dead workers a chunk is given up
MOST_FRUITLESS = 8  #: after so many broken pools without a finished chunk in between the executor is given up
# Exceptions that mean that a worker died, not that the task is wrong; by name, because Dask, Ray and loky may be
# absent.
_DEAD = {"KilledWorker", "WorkerCrashedError", "NodeDiedError", "RayActorError", "ActorDiedError", "ObjectLostError",
         "OwnerDiedError", "LocalRayletDiedError", "NodePreemptedError", "OutOfMemoryError", "CancelledError",
         "FutureCancelledError", "CommClosedError", "TerminatedWorkerError"}


class LostServer(StiefelError):
    """The server of a worker ended, or could not be reached, while it computed a chunk."""

    code = grpc.StatusCode.UNAVAILABLE


class OtherNumerics(StiefelError):
    """The server of a worker would compute other bits than the server with which the sweep began."""

    code = grpc.StatusCode.FAILED_PRECONDITION


class SweepFailed(StiefelError):
    """The sweep ended before its last chunk. Finished chunks are in `partial` and in the store, if there is one."""

    code = grpc.StatusCode.ABORTED
    done: int = 0  #: how many chunks are finished
    chunks: int = 0  #: how many chunks the sweep has
    failures: dict[str, int]  #: how often chunks failed, by the name of the exception

    def __init__(self, message: str, done: int = 0, chunks: int = 0, failures: Optional[dict[str, int]] = None):
        super().__init__(message)
        self.done, self.chunks, self.failures = done, chunks, failures or {}

    def __str__(self) -> str:
        return self.message


class Failures:
    """Counts failures, and tells when there were too many."""

    def __init__(self) -> None:
        self.counted: Counter[str] = Counter()
        self._chunks: Counter[int] = Counter()

    def may_try_again(self, chunk: int, error: BaseException) -> bool:
        """Counts the error, and returns whether the chunk may be tried again."""
        self.counted[type(error).__name__] += 1
        if not is_dead_worker(error):
            return False
        self._chunks[chunk] += 1
        return self._chunks[chunk] < ATTEMPTS

    def of(self, chunk: int) -> int:
        return self._chunks[chunk]


def at(error: InvalidArgument, where: str) -> InvalidArgument:
    """Returns the error with the place in the sweep, such as "at point 5", added."""
    return InvalidArgument(f"{error.message} ({where})",
                           tuple(Violation(v.field, f"{v.description} ({where})") for v in error.violations), error.reason)


def is_dead_worker(error: BaseException) -> bool:
    """Returns whether the error is the worker's, so that another worker may compute the same task."""
    if isinstance(error, (BrokenExecutor, LostServer, OtherNumerics, ConnectionError)):
        return True
    return any(kind.__name__ in _DEAD for kind in type(error).__mro__)
