"""Gives the chunks of a plan to workers, and takes their results as they come."""
from __future__ import annotations

from collections import deque
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import replace
from typing import Any, Callable, Iterable, Optional

from numpy.typing import NDArray

from stiefel.errors import InvalidArgument
from stiefel.sweeps.executors import Workers
from stiefel.sweeps.failures import Failures, SweepFailed
from stiefel.sweeps.plan import Plan, place_violations
from stiefel.sweeps.resolution import Question, Resolved
from stiefel.sweeps.result import canonical
from stiefel.sweeps.shared_store import Place, Written

Take = Callable[[int, "dict[str, NDArray[Any]]"], None]
TakeWritten = Callable[[int, Written], bool]
GRACE = 5.0  #: seconds for chunks that have begun when the sweep fails
QUESTION = -1  # its place among the failures of chunks


def ask_until_answered(question: Question, workers: Workers, failures: Failures) -> "list[Resolved]":
    """The answer of some worker. The question is given again while workers die. SweepFailed after too many."""
    while True:
        try:
            again = tuple(replace(task, attempt=failures.of(QUESTION)) for task in question.tasks)
            return workers.ask(replace(question, tasks=again)).result()
        except (Exception, CancelledError) as error:
            if not failures.may_try_again(QUESTION, error):
                if failures.of(QUESTION) == 0:
                    raise
                raise SweepFailed(f"no worker answered: {_text(error)}", failures=dict(failures.counted)) from error
            if not workers.replace(error):
                raise SweepFailed(f"the executor takes no tasks: {_text(error)}", failures=dict(failures.counted)) from error


def run_chunks(plan: Plan, chunks: Iterable[int], workers: Workers, failures: Failures, take: Take,
               place: Callable[[int], Optional[Place]] = lambda chunk: None,
               take_written: TakeWritten = lambda chunk, written: False) -> None:
    """`take` gets each chunk with its numbers, in the order in which they finish.

    `place`: where a worker may write a chunk; `take_written` gets a chunk that its worker wrote. False: it is not there,
    and the chunk is given again.

    A chunk whose worker died is given again, at most `ATTEMPTS` times. SweepFailed where that or the executor does not
    suffice; what a task itself raises is raised as it is. What has begun by then may finish within `GRACE` seconds, and
    the rest is cancelled where the executor can.
    """
    waiting = deque(chunks)
    running: "dict[Future[Any], int]" = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers.window:
                chunk = waiting.popleft()
                task = replace(plan.task(chunk), place=place(chunk), attempt=failures.of(chunk))
                running[workers.give(task)] = chunk
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                chunk = running.pop(future)
                try:
                    reduced = future.result()
                except (Exception, CancelledError) as error:
                    _again_or_raise(error, chunk, plan, workers, failures)
                    waiting.append(chunk)
                else:
                    workers.finished()
                    if not isinstance(reduced, Written):
                        take(chunk, canonical(reduced))
                    elif not take_written(chunk, reduced):
                        waiting.append(chunk)
    except Exception:
        _take_what_has_begun(running, take, take_written)
        raise
    finally:
        for future in running:
            future.cancel()


def _take_what_has_begun(running: "dict[Future[Any], int]", take: Take, take_written: TakeWritten) -> None:
    begun = {future: chunk for future, chunk in running.items() if not future.cancel()}
    for future in wait(begun, timeout=GRACE).done:
        if future.cancelled() or future.exception() is not None:
            continue
        reduced = future.result()
        if isinstance(reduced, Written):
            take_written(begun[future], reduced)
        else:
            take(begun[future], canonical(reduced))


def _again_or_raise(error: BaseException, chunk: int, plan: Plan, workers: Workers, failures: Failures) -> None:
    """Returns where the chunk may be given again."""
    if not failures.may_try_again(chunk, error):
        if failures.of(chunk) == 0:  # no worker's fault
            raise place_violations(error, plan, chunk) if isinstance(error, InvalidArgument) else error
        points = plan.points(chunk)
        raise SweepFailed(f"the chunk of points {points[0]} to {points[-1]} failed {failures.of(chunk)} times, at last with "
                          f"{_text(error)}", failures=dict(failures.counted)) from error
    if not workers.replace(error):
        raise SweepFailed(f"the executor takes no more tasks: {_text(error)}", failures=dict(failures.counted)) from error


def _text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
