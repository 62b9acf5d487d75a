"""Gives the tasks of a plan to those who compute them: a server of this process, running servers, or the workers of an
executor. Takes the results as they arrive."""
from __future__ import annotations

import queue
from collections import Counter, deque
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from contextvars import ContextVar
from dataclasses import replace
from typing import Any, Callable, Iterable, Optional, Sequence, TypeVar, Union

from stiefel._given.numbers import refused
from stiefel._sweep.own_server import TIMEOUT, LostServer, OwnServer, Share
from stiefel._sweep.plan import Plan, Task
from stiefel._client import Client
from stiefel.errors import InvalidArgument, StiefelError

AHEAD = 4  #: tasks in flight per worker
UNKNOWN = 512  #: tasks in flight at an executor that does not say how many workers it has
CALLS = 2  #: calls in flight per server, so that it computes one while the other's numbers travel
#: A future with whose exception the sweeps of this context end.
STOP: "ContextVar[Optional[Future[None]]]" = ContextVar("STOP", default=None)
ATTEMPTS = 16  #: after so many lost workers a task is given up
# Exceptions that mean that a worker died, not that the task is wrong; by name, because Dask and Ray may be absent.
_DEAD = {"KilledWorker", "WorkerCrashedError", "NodeDiedError", "RayActorError", "ActorDiedError", "ObjectLostError",
         "OwnerDiedError", "LocalRayletDiedError", "NodePreemptedError", "OutOfMemoryError", "CancelledError",
         "FutureCancelledError", "CommClosedError"}
T = TypeVar("T")


class SweepFailed(StiefelError):
    """The sweep ended before its last chunk. Finished chunks are in `partial` and in the store, if there is one."""


class Servers:
    """Running servers, each of which gets a few calls at a time. Thread-safe."""

    def __init__(self, servers: Sequence[Union[str, Client]]):
        self._own = [Client(one, timeout=TIMEOUT) for one in servers if isinstance(one, str)]
        for client in self._own:
            client._connection.waits = False  # another server takes what one that went has left
        self._free: "queue.SimpleQueue[Client]" = queue.SimpleQueue()
        for client in (self._own + [one for one in servers if isinstance(one, Client)]) * CALLS:
            self._free.put(client)

    def use(self, function: Callable[[Client], T], share: Share) -> T:
        client = self._free.get()
        try:
            return function(client)
        finally:
            self._free.put(client)

    def stop(self) -> None:
        for client in self._own:
            client.close()


class Workers:
    """Gives tasks to an executor. `servers`: those of this process that compute them; None: each worker has its own."""

    def __init__(self, executor: Any, servers: Union[OwnServer, Servers, None] = None):
        self._executor, self._servers = executor, servers

    def submit(self, function: Callable[..., T], task: Task) -> "Future[T]":
        return self._executor.submit(function, task, *([self._servers] if self._servers else ()))  # type: ignore[no-any-return]

    @property
    def window(self) -> int:
        """The most tasks in flight."""
        dask: Any = getattr(self._executor, "_client", None)
        count = sum(dask.nthreads().values()) if hasattr(dask, "nthreads") else getattr(self._executor, "_max_workers", 0)
        return AHEAD * count or UNKNOWN

    def close(self) -> None:
        if self._servers:
            self._servers.stop()  # ends running calls
            self._executor.shutdown(wait=True)
            self._servers.stop()


def workers_for(executor: Optional[Executor], servers: Optional[Sequence[Union[str, Client]]]) -> Workers:
    """Returns the workers for the arguments of `sweep`. Raises InvalidArgument if both are given or one is wrong."""
    if servers is not None and executor is not None:
        raise refused("executor", "servers are given too: must be one of them")
    if servers is not None:
        if isinstance(servers, str) or not servers or not all(isinstance(one, (str, Client)) for one in servers):
            raise refused("servers", f"{servers!r}: must be a list of addresses or clients")
        return Workers(ThreadPoolExecutor(CALLS * len(servers)), Servers(servers))
    if executor is None:
        return Workers(ThreadPoolExecutor(CALLS), OwnServer())
    if not callable(getattr(executor, "submit", None)):
        raise refused("executor", f"{executor!r}: must have submit(function, *arguments), as the executors of concurrent.futures")
    return Workers(executor)


def spread(plan: Plan, chunks: Iterable[int], function: Callable[[Task], T], workers: Workers, failures: "Counter[str]",
           take: Callable[[int, T], None]) -> None:
    """Computes `function` of the tasks of chunks. `take` gets the number of each chunk with its result, in the order in
    which they finish. A task whose worker was lost is given again; `failures` counts this by the name of the exception. At
    an exception, `take` gets the results that are there, and tasks that have not begun are cancelled."""
    left, stop, attempts = deque(chunks), STOP.get(), Counter[int]()
    running: "dict[Future[T], int]" = {}

    def again(chunk: int, error: Exception) -> None:
        attempts[chunk] += 1
        failures[type(error).__name__] += 1
        check(error, attempts[chunk], plan.name(chunk))
        left.append(chunk)

    try:
        while left or running:
            while left and len(running) < workers.window:
                chunk = left.popleft()
                try:
                    running[workers.submit(function, replace(plan.task(chunk), attempt=attempts[chunk]))] = chunk
                except BrokenExecutor as error:  # the pool broke after its last result was taken
                    again(chunk, error)
            ended = wait([*running, *([stop] if stop else ())], return_when=FIRST_COMPLETED).done
            if stop is not None and stop in ended:
                stop.result()
            for future in ended:
                chunk = running.pop(future)
                try:
                    result = future.result()
                except Exception as error:
                    again(chunk, error)
                else:
                    take(chunk, result)
    finally:
        for future, chunk in running.items():
            if not future.cancel() and future.done() and future.exception() is None:
                take(chunk, future.result())


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
