"""Where tasks are computed: at a server here, at running servers, or wherever an executor of futures takes them."""
from __future__ import annotations

import queue
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any, Callable, Optional, Sequence, Union

from stiefel.client import Client
from stiefel.errors import InvalidArgument, Violation
from stiefel.sweeps.chunks import Task
from stiefel.sweeps.failures import FRUITLESS, LostServer
from stiefel.sweeps.own_server import TIMEOUT, OwnServer, Share
from stiefel.sweeps.resolution import Question, Resolved, answer, answer_at
from stiefel.sweeps.worker import compute, compute_at

AHEAD = 4  #: tasks that each worker may have waiting
UNKNOWN = 512  #: tasks given at once to an executor that does not say how many workers it has
CALLS = 2  #: calls at once at a server, so that it computes one while the other's numbers travel
PAUSE = 0.5  #: seconds before a server that was lost is called again

Given = Union[Executor, Callable[[], Executor]]


class Workers:
    """Gives tasks to an executor. A process pool that broke is replaced by one like it."""

    elsewhere = True  #: tasks run in other processes, which may write to a store

    def __init__(self, executor: Given):
        self._make = None if isinstance(executor, Executor) else executor
        self._mine = not isinstance(executor, Executor)
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
        """Tasks that are given at once."""
        count: Optional[int] = getattr(self._executor, "_max_workers", None)
        if count is None:
            threads = getattr(getattr(self._executor, "_client", None), "nthreads", None)  # of Dask
            count = sum(threads().values()) if callable(threads) else None
        return AHEAD * count if count else UNKNOWN

    def finished(self) -> None:
        """A task has finished since the last replacement."""
        self._broken = 0

    def replace(self, error: BaseException) -> bool:
        """After a worker died: whether there is an executor that takes tasks."""
        if not isinstance(error, BrokenExecutor) or not _is_broken(self._executor):
            return True
        self._broken += 1
        if self._broken >= FRUITLESS:
            return False
        make = self._make or _like(self._executor)
        if make is None:
            return False
        if self._mine:
            self._executor.shutdown(wait=False)
        self._executor, self._mine = make(), True
        return True

    def close(self) -> None:
        if self._mine:
            self._executor.shutdown(wait=True)

    def _submit(self, function: Callable[..., Any], argument: Any) -> "Future[Any]":
        try:
            return self._executor.submit(function, argument)  # type: ignore[no-any-return]
        except BrokenExecutor as error:  # the pool broke since the last look
            failed: "Future[Any]" = Future()
            failed.set_exception(error)
            return failed


def _is_broken(executor: Any) -> bool:
    """A process pool says so itself; one that does not is taken to be broken."""
    return bool(getattr(executor, "_broken", True))


def _like(executor: Any) -> Optional[Callable[[], Executor]]:
    """A process pool with the same arguments; None for other executors."""
    if type(executor) is not ProcessPoolExecutor:
        return None
    pool: Any = executor
    workers, context, start, arguments = pool._max_workers, pool._mp_context, pool._initializer, pool._initargs
    return lambda: ProcessPoolExecutor(workers, mp_context=context, initializer=start, initargs=arguments)


class Servers(Workers):
    """Threads of this process that call running servers, each server with a few calls at once."""

    elsewhere = False

    def __init__(self, servers: Sequence[Union[str, Client]]):
        if isinstance(servers, str) or not servers or not all(isinstance(one, (str, Client)) for one in servers):
            rule = f"{servers!r}: must be a list of addresses or clients"
            raise InvalidArgument(f"servers: {rule}", (Violation("servers", rule),))
        self._own = [Client(one, timeout=TIMEOUT) for one in servers if isinstance(one, str)]
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
    """Threads of this process that call one server of its own, which computes on `threads` cores, 0: on all."""

    elsewhere = False

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
        self._server.stop()  # ends calls that still run
        super().close()
        self._server.stop()


def workers_for(executor: Optional[Given], servers: Optional[Sequence[Union[str, Client]]],
                threads: Optional[int]) -> Workers:
    """InvalidArgument where both are given, or neither an executor nor what makes one."""
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
