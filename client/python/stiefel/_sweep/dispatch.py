"""Gives questions and the chunks of a plan to workers, and takes the results as they arrive."""
from __future__ import annotations

from collections import deque
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextvars import ContextVar
from dataclasses import replace
from typing import Any, Callable, Iterable, Optional, Union

from numpy.typing import NDArray

from stiefel.errors import InvalidArgument
from stiefel._sweep.executors import Workers
from stiefel._sweep.failures import Failures, SweepFailed
from stiefel._sweep.plan import Plan, place_violations
from stiefel._sweep.reduction import Reduced
from stiefel._sweep.resolution import Question, Resolved
from stiefel._sweep.result import canonical
from stiefel._sweep.shared_store import Place, Written
from stiefel._sweep.warned import Warned

Take = Callable[[int, "dict[str, NDArray[Any]]"], None]
TakeWritten = Callable[[int, Written], bool]
TakeAnswer = Callable[[int, "list[Resolved]"], None]
GRACE = 5.0  #: seconds in which running chunks may still finish when the sweep fails
#: A future with whose exception the sweeps of this context end.
STOP: "ContextVar[Optional[Future[None]]]" = ContextVar("STOP", default=None)


def ask_all(count: int, question: Callable[[int], Question], workers: Workers, failures: Failures, take: TakeAnswer) -> None:
    """Asks `count` questions. `take` gets the number of each question with a worker's answer, in the order of arrival.
    A question whose worker died is asked again. Raises SweepFailed when too many workers died."""
    def ask(k: int) -> "Future[Any]":
        asked = question(k)
        again = tuple(replace(task, attempt=failures.of(_place(k))) for task in asked.tasks)
        return workers.ask(replace(asked, tasks=again))

    def check(error: BaseException, k: int) -> None:
        if not failures.may_try_again(_place(k), error):
            if failures.of(_place(k)) == 0:
                raise error
            raise SweepFailed(f"no worker answered: {_text(error)}", failures=dict(failures.counted)) from error
        if not workers.replace(error):
            raise SweepFailed(f"the executor takes no tasks: {_text(error)}", failures=dict(failures.counted)) from error

    def taken(k: int, answer: "list[Resolved]") -> bool:
        take(k, answer)
        return True

    _spread(range(count), workers, ask, taken, check, grace=0)


def run_chunks(plan: Plan, chunks: Iterable[int], workers: Workers, failures: Failures, take: Take,
               place: Callable[[int], Optional[Place]] = lambda chunk: None,
               take_written: TakeWritten = lambda chunk, written: False, warned: Optional[Warned] = None) -> None:
    """Computes chunks. `take` gets the number of each chunk with its arrays, in the order in which they finish.

    `place` returns where a worker may write a chunk into a store. `take_written` gets a chunk that its worker wrote,
    and returns False if it is not there, after which the chunk is computed again. `warned` gets the servers' warnings.

    A chunk whose worker died is given again, until it has failed `ATTEMPTS` times. Raises SweepFailed after that, or if
    the executor takes no more tasks; an exception of the task itself is raised unchanged. Running chunks may then still
    finish within `GRACE` seconds; all others are cancelled if the executor can do so.
    """
    def give(chunk: int) -> "Future[Any]":
        return workers.give(replace(plan.task(chunk), place=place(chunk), attempt=failures.of(chunk)))

    def taken(chunk: int, reduced: Union[Reduced, Written]) -> bool:
        there = True
        if isinstance(reduced, Written):
            there = take_written(chunk, reduced)
        else:
            take(chunk, canonical(reduced))
        if there and warned is not None:
            warned.take(plan.points(chunk), reduced.warnings)
        return there

    _spread(chunks, workers, give, taken, lambda error, chunk: _again_or_raise(error, chunk, plan, workers, failures), GRACE)


def _spread(waiting: Iterable[int], workers: Workers, give: Callable[[int], "Future[Any]"], take: Callable[[int, Any], bool],
            check: Callable[[BaseException, int], None], grace: float) -> None:
    """Gives all of `waiting` to the workers, at most `Workers.window` at once, and passes the results to `take`. Gives
    again what `take` refuses by returning False, and what failed with an error for which `check` does not raise. After
    an exception, running tasks may still finish within `grace` seconds."""
    left, stop = deque(waiting), STOP.get()
    running: "dict[Future[Any], int]" = {}
    try:
        while left or running:
            while left and len(running) < workers.window:
                one = left.popleft()
                running[give(one)] = one
            ended = wait([*running, *([stop] if stop else ())], return_when=FIRST_COMPLETED).done
            if stop is not None and stop in ended:
                grace = 0
                stop.result()
            for future in ended:
                one = running.pop(future)
                try:
                    result = future.result()
                except (Exception, CancelledError) as error:
                    check(error, one)
                    left.append(one)
                else:
                    workers.finished()
                    if not take(one, result):
                        left.append(one)
    except Exception:
        begun = {future: one for future, one in running.items() if not future.cancel()}
        for future in wait(begun, timeout=grace).done:
            if not future.cancelled() and future.exception() is None:
                take(begun[future], future.result())
        raise
    finally:
        for future in running:
            future.cancel()


def _again_or_raise(error: BaseException, chunk: int, plan: Plan, workers: Workers, failures: Failures) -> None:
    """Returns if the chunk may be given again, else raises."""
    if not failures.may_try_again(chunk, error):
        if failures.of(chunk) == 0:  # the error is the task's, not a worker's
            raise place_violations(error, plan, chunk) if isinstance(error, InvalidArgument) else error
        points = plan.points(chunk)
        raise SweepFailed(f"the chunk of points {points[0]} to {points[-1]} failed {failures.of(chunk)} times, at last with "
                          f"{_text(error)}", failures=dict(failures.counted)) from error
    if not workers.replace(error):
        raise SweepFailed(f"the executor takes no more tasks: {_text(error)}", failures=dict(failures.counted)) from error


def _place(question: int) -> int:
    """Returns the number under which `Failures` counts a question: negative, because chunks have the others."""
    return -1 - question


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
