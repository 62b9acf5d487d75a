"""Reads the stream of a Summarize, and resumes it where it broke."""
from __future__ import annotations

import dataclasses
from contextlib import closing
from typing import Any, Iterator, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome, Price, RunStatus
from stiefel._results.origin import Origin
from stiefel._wire import answers, replies
from stiefel._wire.arrays import Assembly, named
from stiefel._wire.recreating import Attempts, Recreation, refuses_checkpoint
from stiefel._wire.replies import Layout, complete, require
from stiefel._wire.retries import Deadline
from stiefel._wire.sampling import Collector
from stiefel._wire.streams import CheckpointParts, progress_bar
from stiefel.errors import StiefelError
from stiefel.results import Batch, Events, Summary, Trajectory


class Summarizing:
    """Iterates over events and states at times as they arrive; the summary is available afterwards.

    A stream that breaks because the server is unavailable or has lost the session is resumed from the last checkpoint
    that came, or begins anew. A stream that ends at its price is resumed from the checkpoint that the server sends before
    the error. Events and states are never yielded twice.
    """

    def __init__(self, handle: Recreation, request: pb.SummarizeRequest, ensemble: bool, timeout: Optional[float],
                 blocks: int = 0):
        """`blocks`: as of Layout."""
        self._handle = handle
        self._request = request
        self._ensemble = ensemble
        self._timeout = timeout
        self._given = request.checkpoint  # the caller's checkpoint
        self._layouts = {kind: Layout(request.fields, axes, blocks) for kind, axes in ((Events, (3,)), (Batch, (3, 4)))}
        self.run_status: Optional[RunStatus] = None  #: set at the end
        self.arrays: dict[str, Array] = {}  #: statistics by name, set at the end
        self.computed_steps = 0
        self.price: Optional[Price] = None
        self.checkpoint = request.checkpoint  #: the last complete checkpoint

    def summary(self) -> Summary:
        """Returns the summary. Call it after the iteration has ended."""
        assert self.run_status is not None
        return answers.summary(self.arrays, self.run_status, self.computed_steps, self.price, self.checkpoint)

    def __iter__(self) -> Iterator[Union[Events, Batch]]:
        with self._handle.explains(self._request.to):
            yield from self._parts()

    def _parts(self) -> Iterator[Union[Events, Batch]]:
        attempts = Attempts(self._handle, Deadline(self._timeout))
        taken = {Events: 0, Batch: 0}  # how many events and states have been yielded
        kept = dict(taken)  # how many of them came before the last checkpoint
        before = 0  # steps computed by broken streams, without those up to the checkpoint
        at_checkpoint = 0  # steps up to the checkpoint, which the next stream counts again
        while True:
            seen, fields, statistics = dict(kept), Assembly(), Assembly()
            computed, parts = 0, CheckpointParts()
            try:
                with closing(self._handle.messages("Summarize", self._request, attempts.deadline.left())) as arriving:
                    for message in arriving:
                        computed = message.computed_steps
                        self.computed_steps = before + computed
                        if self.price is None:
                            self.price = replies.price(complete(message, "price").price)
                        statistics.take(message.statistics)
                        batch = self._read(message, fields)
                        if batch is not None:
                            kind, count = type(batch), batch.count if isinstance(batch, Events) else batch.samples
                            if isinstance(batch, Batch):
                                asked = self._request.times[seen[Batch]:seen[Batch] + count]
                                require(list(asked) == batch.time.tolist(), "its states are not at the times asked for")
                            old = max(0, min(count, taken[kind] - seen[kind]))
                            seen[kind] += count
                            if old < count:
                                taken[kind] = seen[kind]
                                yield batch if old == 0 else _after(batch, old)
                        whole = parts.take(message.checkpoint) if message.HasField("checkpoint") else b""
                        if whole:
                            kept, self._request.checkpoint, self.checkpoint = dict(seen), whole, whole
                            at_checkpoint = computed
                            attempts.renew()
                        if message.HasField("run_status"):
                            self.run_status = replies.run_status(message.run_status)
                            self.arrays = statistics.finish()
                            self._check_end(seen[Batch], fields)
                            self.arrays = answers.named_statistics(self.arrays)
                            return
            except StiefelError as broken:
                error: StiefelError = broken
            else:
                raise AssertionError("a stream ends with an exception")
            before += computed - at_checkpoint if computed else 0
            if self._request.checkpoint != self._given and refuses_checkpoint(error):
                # This server has another build: the stream begins anew.
                kept, self._request.checkpoint = dict.fromkeys(kept, 0), self._given
                before, at_checkpoint = before + at_checkpoint, 0
                continue
            attempts.again(error)

    def _read(self, message: pb.SummarizeResponse, assembly: Assembly) -> Union[Events, Batch, None]:
        """Reads a message and returns the events or states that it completes."""
        batch: Union[pb.EventBatch, pb.StateBatch]
        if message.HasField("events"):
            batch, count = message.events, {len(message.events.steps), *map(len, (
                message.events.events, message.events.fractions, message.events.times))}
            if self._ensemble:
                count.add(len(message.events.members))
            require(all(event < len(self._request.events) for event in message.events.events), "it has an unknown event")
        elif message.HasField("states"):
            batch, count = message.states, {len(message.states.steps), len(message.states.times)}
        else:
            return None
        require(len(count) == 1, "its events or states have lists of different lengths")
        assembly.take(batch.fields)
        if message.continues:
            return None
        fields = assembly.finish()
        self._layouts[Events if message.HasField("events") else Batch].check(fields, count.pop())
        fields = named(fields)
        if message.HasField("events"):
            return answers.events(message.events, fields, self._ensemble)
        return Batch(np.array(batch.steps, np.int64), np.array(batch.times), fields)

    def _check_end(self, states: int, fields: Assembly) -> None:
        """Checks that all has come: every state, unless the run stopped or an event may have ended it, and the
        statistics."""
        assert self.run_status is not None
        require(not fields.begun, "the last event or state is incomplete")
        may_end = self.run_status.outcome != Outcome.REACHED or any(event.terminal for event in self._request.events)
        require(may_end or states == len(self._request.times), f"it has {states} states")
        answers.check_statistics(self.arrays, self._request, self._ensemble)
        require((self.run_status.outcome == Outcome.REACHED) == bool((self.arrays["outcome"] == pb.OUTCOME_REACHED).all()),
                f"it is {self.run_status.outcome}, and its motions are not")


def _after(batch: Union[Events, Batch], count: int) -> Union[Events, Batch]:
    """Returns what comes after the first `count` elements."""
    arrays = {field.name: getattr(batch, field.name) for field in dataclasses.fields(batch)}
    rest: dict[str, Any] = {name: array[count:] for name, array in arrays.items() if isinstance(array, np.ndarray)}
    return dataclasses.replace(batch, fields={name: values[count:] for name, values in batch.fields.items()}, **rest)


def states_at(running: Summarizing, order: NDArray[np.intp], origin: Origin, progress: bool) -> Trajectory:
    """Returns the states at times in the order in which the caller gave them. `running` yields them sorted; the k-th of
    them is the one that the caller gave as number `order[k]`. An exception has those that arrived in `partial`, and
    names times by their index in the caller's list."""
    collector = Collector(order.size, origin)

    def arrived(run_status: RunStatus) -> Trajectory:
        run = collector.trajectory(run_status, running.computed_steps)
        back = np.argsort(order[:run.samples], kind="stable")
        return Trajectory(run.step[back], run.time[back], {name: values[back] for name, values in run.fields.items()},
                          run.run_status, run.computed_steps, origin)

    try:
        with progress_bar(order.size, progress, " states") as bar:
            for part in running:
                if isinstance(part, Batch):
                    collector.add(part)
                    bar.update(part.samples)
    except StiefelError as error:
        error._as_given("times", order.tolist())
        error.partial = arrived(RunStatus(Outcome.CANCELLED, message=error.message))
        raise
    return arrived(running.run_status or RunStatus(Outcome.CANCELLED))


def in_given_order(parts: Sequence[tuple[Trajectory, NDArray[np.intp]]]) -> Trajectory:
    """Joins states after time 0 with those before it, which come last. Each part comes with the places of its states in the
    caller's list."""
    runs = [run for run, _ in parts]
    runs[-1] = dataclasses.replace(runs[-1], step=-runs[-1].step)  # from the scene with a step of the other sign
    order = np.argsort(np.concatenate([places for _, places in parts]), kind="stable")
    status = next((run.run_status for run in runs if run.run_status.outcome is not Outcome.REACHED), runs[0].run_status)
    return dataclasses.replace(
        runs[0], step=np.concatenate([run.step for run in runs])[order],
        time=np.concatenate([run.time for run in runs])[order], run_status=status,
        fields={name: np.concatenate([run.fields[name] for run in runs])[order] for name in runs[0].fields},
        computed_steps=sum(run.computed_steps for run in runs))
