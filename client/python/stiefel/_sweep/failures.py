"""The failures of tasks, and whether a task may be given again."""
from __future__ import annotations

from concurrent.futures import BrokenExecutor

from stiefel.errors import Closed, CorruptReply, DeadlineExceeded, InvalidArgument, NotFound, StiefelError, Unavailable

ATTEMPTS = 16  #: after so many lost workers a task is given up
# Exceptions that mean that a worker died, not that the task is wrong; by name, because Dask and Ray may be absent.
_DEAD = {"KilledWorker", "WorkerCrashedError", "NodeDiedError", "RayActorError", "ActorDiedError", "ObjectLostError",
         "OwnerDiedError", "LocalRayletDiedError", "NodePreemptedError", "OutOfMemoryError", "CancelledError",
         "FutureCancelledError", "CommClosedError"}


class LostServer(StiefelError):
    """The server of a worker ended, could not be reached, or would compute other bits than the sweep's first server."""


#: Errors of a call that another server may answer.
GONE = (Unavailable, NotFound, CorruptReply, DeadlineExceeded, Closed)


class SweepFailed(StiefelError):
    """The sweep ended before its last chunk. Finished chunks are in `partial` and in the store, if there is one."""


def check(error: Exception, attempts: int, name: str) -> None:
    """Returns if another worker may compute the task that failed so often. Raises SweepFailed if the executor is broken or
    the task failed too often, and the error itself if it is not the worker's. `name`: that of the task."""
    said = f"{type(error).__name__}: {error}"
    if isinstance(error, BrokenExecutor):
        raise SweepFailed(f"the executor takes no more tasks: {said}") from error
    lost = isinstance(error, (LostServer, ConnectionError)) or not _DEAD.isdisjoint(kind.__name__ for kind in type(error).__mro__)
    if not lost:  # then no other worker may compute the same task
        if isinstance(error, InvalidArgument):
            error._say(f"{error.message} (in {name})")
        raise error
    if attempts >= ATTEMPTS:
        raise SweepFailed(f"{name} failed {attempts} times, at last with {said}") from error
