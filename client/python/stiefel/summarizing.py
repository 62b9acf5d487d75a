"""Reads the stream of a Summarize, and resumes it where it broke."""
from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Any, Iterator, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import calls, recreation
from stiefel import v1 as pb
from stiefel.arrays import Array, Batch, Collector, Outcome, Price, RunStatus, Trajectory
from stiefel.assembly import Assembly
from stiefel.checksums import verify
from stiefel.errors import FailedPrecondition, NotFound, StiefelError, Unavailable
from stiefel.given.numbers import SECONDS, numbers, refused
from stiefel.recreation import Recreation
from stiefel.replies import Layout, complete, require
from stiefel.streams import CheckpointParts, messages, progress_bar
from stiefel.summary import Events, Summary, check_statistics

if TYPE_CHECKING:
    from stiefel.client import Client

MOST_STEPS = 2.0**53  #: beyond it a double does not tell one step from the next


class Summarizing:
    """Iterates over events and states at times as they arrive; the summary is available afterwards.

    A stream that breaks because the server is unavailable or has lost the session is resumed from the last checkpoint
    that came, or begins anew. A stream that ends at its price is resumed from the checkpoint that the server sends before
    the error. Events and states are never yielded twice.
    """

    def __init__(self, client: Client, recreation: Recreation, request: pb.SummarizeRequest, ensemble: bool,
                 timeout: Optional[float]):
        self._client = client
        self._recreation = recreation
        self._request = request
        self._ensemble = ensemble
        self._timeout = timeout
        self._given = request.checkpoint  # the caller's checkpoint
        self._layouts = {Events: Layout(request.fields, axes=(3,)), Batch: Layout(request.fields, axes=(3, 4))}
        self.run_status: Optional[RunStatus] = None  #: set at the end
        self.arrays: dict[str, Array] = {}  #: statistics by name, set at the end
        self.computed_steps = 0
        self.price: Optional[Price] = None
        self.checkpoint = request.checkpoint  #: the last complete checkpoint
        self.checkpoint_ignored = False  #: whether a server ignored the caller's checkpoint

    def summary(self) -> Summary:
        """Returns the summary. Call it after the iteration has ended."""
        assert self.run_status is not None
        return Summary.of(self.arrays, self.run_status, self.computed_steps, self.price, self.checkpoint,
                          self.checkpoint_ignored)

    def __iter__(self) -> Iterator[Union[Events, Batch]]:
        with self._recreation.explains(self._request.to):
            yield from self._parts()

    def _parts(self) -> Iterator[Union[Events, Batch]]:
        deadline, waits, recoveries = calls.Deadline(self._timeout), calls.Pauses(), recreation.pauses()
        taken = {Events: 0, Batch: 0}  # how many events and states have been yielded
        kept = dict(taken)  # how many of them came before the last checkpoint
        before = 0  # steps computed by broken streams, without those up to the checkpoint
        at_checkpoint = 0  # steps up to the checkpoint, which the next stream counts again
        while True:
            stream = self._client.stub.Summarize(self._request, timeout=deadline.left(),
                                                 metadata=self._recreation.metadata)
            seen, fields, statistics = dict(kept), Assembly(), Assembly()
            computed, parts = 0, CheckpointParts()
            try:
                with closing(messages(self._client, self._recreation, stream)) as arriving:
                    for message in arriving:
                        self._verify(message)
                        if message.checkpoint_ignored:  # the server does not have its key: the stream begins anew
                            seen, kept = dict.fromkeys(seen, 0), dict.fromkeys(kept, 0)
                            before, at_checkpoint = before + at_checkpoint, 0
                            self._forget_checkpoint(any(taken.values()))
                        computed = message.computed_steps
                        self.computed_steps = before + computed
                        if self.price is None:
                            self.price = Price.of(complete(message, "price").price)
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
                            waits, recoveries = calls.Pauses(), recreation.pauses()
                        if message.HasField("run_status"):
                            self.run_status = RunStatus.of(message.run_status)
                            self.arrays = statistics.finish()
                            self._check_end(seen[Batch], fields)
                            return
            except StiefelError as broken:
                error: StiefelError = broken
            before += computed - at_checkpoint if computed else 0
            if self._request.checkpoint != self._given and recreation.refuses_checkpoint(error):
                # This server has another build: the stream begins anew.
                kept, self._request.checkpoint = dict.fromkeys(kept, 0), self._given
                before, at_checkpoint = before + at_checkpoint, 0
                continue
            try:
                calls.pause_or_raise(error, waits, self._client, deadline, late=True)
            except (NotFound, Unavailable) as lost:
                self._recreation.recover(lost, recoveries, deadline)

    def _forget_checkpoint(self, yielded: bool) -> None:
        """Raises FailedPrecondition if the caller's checkpoint was taken before and something was yielded since, because
        nobody could tell what of this stream is new."""
        if self._given and yielded:
            raise FailedPrecondition("checkpoint: the call goes on at a server that does not have its key")
        self.checkpoint_ignored |= bool(self._given)
        self._given = self._request.checkpoint = self.checkpoint = b""

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
        if message.HasField("events"):
            return Events.of(message.events, fields, self._ensemble)
        return Batch(np.array(batch.steps, np.int64), np.array(batch.times), fields)

    def _check_end(self, states: int, fields: Assembly) -> None:
        """Checks that all has come: every state, unless the run stopped or an event may have ended it, and the
        statistics."""
        assert self.run_status is not None
        require(not fields.begun, "the last event or state is incomplete")
        may_end = self.run_status.outcome != Outcome.REACHED or any(event.terminal for event in self._request.events)
        require(may_end or states == len(self._request.times), f"it has {states} states")
        check_statistics(self.arrays, self._request, self._ensemble)
        require((self.run_status.outcome == Outcome.REACHED) == bool((self.arrays["outcome"] == pb.OUTCOME_REACHED).all()),
                f"it is {self.run_status.outcome}, and its motions are not")

    def _verify(self, message: pb.SummarizeResponse) -> None:
        if not (message.HasField("checksum") or self._request.checksum):
            return
        events, states = message.events, message.states

        def data(values: Any, dtype: str) -> bytes:
            return np.array(values, dtype).tobytes()

        verify(message, [
            data(message.step, "<i8"), data(events.events, "<u4"), data(events.steps, "<i8"),
            data(events.fractions, "<f8"), data(events.times, "<f8"), data(events.members, "<u4"),
            *(field.value.data for field in events.fields), data(states.steps, "<i8"), data(states.times, "<f8"),
            *(field.value.data for field in states.fields), message.checkpoint.data,
            *(field.value.data for field in message.statistics)], "a message of the summary", self._request.checksum)


def _after(batch: Union[Events, Batch], count: int) -> Union[Events, Batch]:
    if isinstance(batch, Events):
        return batch.after(count)
    return Batch(batch.step[count:], batch.time[count:], {name: values[count:] for name, values in batch.items()})


def in_steps(times: Sequence[float], step: float) -> tuple[Array, Array]:
    """Returns the times as an array, and how many steps of the length `step` after time 0 each of them is: a whole number
    where it is one to rounding, as the engine takes it. Raises InvalidArgument that names the first wrong one."""
    given = np.atleast_1d(numbers("times", times, SECONDS))
    if given.ndim != 1 or not given.size:
        raise refused("times", f"the shape {given.shape}: must be (times), one or more")
    steps = given / step
    other = "a negative" if step > 0 else "a positive"
    for wrong, rule in ((~np.isfinite(steps), "must be finite"),
                        (steps < 0, f"must be 0 or have the sign of the scene's step {step!r}; for this time, use {other} step"),
                        (abs(steps) > MOST_STEPS, f"must be at most {MOST_STEPS:.0e} steps from time 0")):
        if wrong.any():
            k = int(np.argmax(wrong))
            raise refused(f"times[{k}]", f"{float(given[k])!r}: {rule}")
    whole = np.rint(steps)
    return given, np.where(abs(steps - whole) <= 3 * 2**-53 * whole, whole, steps)


def states_at(running: Summarizing, order: NDArray[np.intp], progress: bool) -> Trajectory:
    """Returns the states at times in the order in which the caller gave them. `running` yields them sorted; the k-th of
    them is the one that the caller gave as number `order[k]`. An exception has those that arrived in `partial`, and
    names times by their index in the caller's list."""
    collector = Collector(order.size)

    def arrived(run_status: RunStatus) -> Trajectory:
        run = collector.trajectory(run_status, running.computed_steps)
        back = np.argsort(order[:run.samples], kind="stable")
        return Trajectory(run.step[back], run.time[back], {name: values[back] for name, values in run.items()},
                          run.run_status, run.computed_steps)

    try:
        with progress_bar(order.size, progress, " states") as bar:
            for part in running:
                if isinstance(part, Batch):
                    collector.add(part)
                    bar.update(part.samples)
    except StiefelError as error:
        error.as_given("times", order)
        error.partial = arrived(RunStatus(Outcome.CANCELLED, message=error.message))
        raise
    return arrived(running.run_status or RunStatus(Outcome.CANCELLED))
