"""Gives tasks to those who compute them: a server of this process, running servers, or the workers of an executor."""
from __future__ import annotations

import queue
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any, Callable, Mapping, Optional, Sequence, Union

from stiefel.client import Client
from stiefel.errors import InvalidArgument, Violation
from stiefel._sweep.chunks import Task
from stiefel._sweep.failures import MOST_FRUITLESS, LostServer
from stiefel._sweep.own_server import TIMEOUT, OwnServer, Share
from stiefel._sweep.resolution import Question, Resolved, answer, answer_at
from stiefel._sweep.worker import compute, compute_at

AHEAD = 4  #: tasks in flight per worker
UNKNOWN = 512  #: tasks in flight at an executor that does not say how many workers it has
CALLS = 2  #: calls in flight per server, so that it computes one while the other's numbers travel
PAUSE = 0.5  #: seconds before a lost server is called again

Given = Union[Executor, Callable[[], Executor]]


class Workers:
    """Gives tasks to an executor. Replaces a broken process pool by one with the same arguments."""

    in_other_processes = True  #: whether tasks run in other processes, which may write to a store

    def __init__(self, executor: Given):
        self._make = None if isinstance(executor, Executor) else executor
        self._owned = not isinstance(executor, Executor)
        self._executor: Any = executor if isinstance(executor, Executor) else executor()
        self._broken = 0
        if not callable(getattr(self._executor, "submit", None)):
            rule = f"{self._executor!r}: must have submit(function, *arguments), as the executors of concurrent.futures"
            raise InvalidArgument(f"executor: {rule}", (Violation("executor", rule),))

    def ask(self, question: Question) -> "Future[list[Resolved]]":
        return self._submit(answer, question)

    def give(self, task: Task) -> "Future[Any]":
        return self._submit(compute, task)

    @property
    def window(self) -> int:
        """The most tasks in flight."""
        count: Optional[int] = getattr(self._executor, "_max_workers", None)
        if count is None:
            dask: Any = getattr(self._executor, "_client", None)
            threads: Optional[Callable[[], Mapping[str, int]]] = getattr(dask, "nthreads", None)
            count = sum(threads().values()) if threads else None
        return AHEAD * count if count else UNKNOWN

    def finished(self) -> None:
        """Tells that a task has finished. Only replacements without a finished task in between count as fruitless."""
        self._broken = 0

    def replace(self, error: BaseException) -> bool:
        """Replaces the executor if `error` means that it is broken. Returns whether there is an executor that takes
        tasks."""
        if not isinstance(error, BrokenExecutor) or not _is_broken(self._executor):
            return True
        self._broken += 1
        if self._broken >= MOST_FRUITLESS:
            return False
        make = self._make or _like(self._executor)
        if make is None:
            return False
        if self._owned:
            self._executor.shutdown(wait=False)
        self._executor, self._owned = make(), True
        return True

    def close(self) -> None:
        if self._owned:
            self._executor.shutdown(wait=True)

    def _submit(self, function: Callable[..., Any], argument: Any) -> "Future[Any]":
        try:
            return self._executor.submit(function, argument)  # type: ignore[no-any-return]
        except BrokenExecutor as error:  # the pool broke after its last result was taken
            failed: "Future[Any]" = Future()
            failed.set_exception(error)
            return failed


def _is_broken(executor: Any) -> bool:
    """Returns whether an executor is broken. A process pool has an attribute for this; others are taken to be
    broken."""
    return bool(getattr(executor, "_broken", True))


def _like(executor: Any) -> Optional[Callable[[], Executor]]:
    """Returns a function that makes a process pool with the same arguments; None for other executors."""
    if type(executor) is not ProcessPoolExecutor:
        return None
    pool: Any = executor
    workers, context, start, arguments = pool._max_workers, pool._mp_context, pool._initializer, pool._initargs
    return lambda: ProcessPoolExecutor(workers, mp_context=context, initializer=start, initargs=arguments)


class Servers(Workers):
    """Gives tasks to running servers, which threads of this process call. Each server gets a few calls at a time."""

    in_other_processes = False

    def __init__(self, servers: Sequence[Union[str, Client]]):
        if isinstance(servers, str) or not servers or not all(isinstance(one, (str, Client)) for one in servers):
            rule = f"{servers!r}: must be a list of addresses or clients"
            raise InvalidArgument(f"servers: {rule}", (Violation("servers", rule),))
        self._own = [Client(one, timeout=TIMEOUT) for one in servers if isinstance(one, str)]
        for client in self._own:
            client._connection.waits = False  # another server takes what one that went has left
        self._free: "queue.SimpleQueue[Client]" = queue.SimpleQueue()
        for client in (self._own + [one for one in servers if isinstance(one, Client)]) * CALLS:
            self._free.put(client)
        super().__init__(lambda: ThreadPoolExecutor(CALLS * len(servers), "stiefel sweep"))

    def ask(self, question: Question) -> "Future[list[Resolved]]":
        return self._submit(self._at_a_free_one, lambda client: answer_at(client, question))

    def give(self, task: Task) -> "Future[Any]":
        return self._submit(self._at_a_free_one, lambda client: compute_at(client, task))

    def _at_a_free_one(self, use: Callable[[Client], Any]) -> Any:
        client = self._free.get()
        try:
            return use(client)
        except LostServer:
            time.sleep(PAUSE)
            raise
        finally:
            self._free.put(client)

    def close(self) -> None:
        for client in self._own:
            client.close()
        super().close()


class Here(Workers):
    """Gives tasks to a server that this process starts, with `threads` threads; 0 or None: all cores."""

    in_other_processes = False

    def __init__(self, threads: Optional[int]):
        self._share = Share(threads or 0)
        self._server = OwnServer()
        super().__init__(lambda: ThreadPoolExecutor(CALLS, "stiefel sweep"))

    def ask(self, question: Question) -> "Future[list[Resolved]]":
        return self._submit(self._here, lambda client: answer_at(client, question))

    def give(self, task: Task) -> "Future[Any]":
        return self._submit(self._here, lambda client: compute_at(client, task))

    def _here(self, use: Callable[[Client], Any]) -> Any:
        return self._server.use(use, self._share)

    def close(self) -> None:
        self._server.stop()  # ends running calls
        super().close()
        self._server.stop()


def workers_for(executor: Optional[Given], servers: Optional[Sequence[Union[str, Client]]],
                threads: Optional[int]) -> Workers:
    """Returns the workers for the arguments of `sweep`. Raises InvalidArgument if both an executor and servers are
    given, or if `executor` is neither an executor nor a function that makes one."""
    if executor is not None and servers is not None:
        rule = "servers are given too: must be one of them"
        raise InvalidArgument(f"executor: {rule}", (Violation("executor", rule),))
    if servers is not None:
        return Servers(servers)
    if executor is None:
        return Here(threads)
    if not isinstance(executor, Executor) and not callable(executor) and not hasattr(executor, "submit"):
        rule = f"{executor!r}: must be an executor of concurrent.futures, or a function that makes one"
        raise InvalidArgument(f"executor: {rule}", (Violation("executor", rule),))
    return Workers(executor)
