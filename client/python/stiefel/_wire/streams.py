"""The readers of streams."""
from __future__ import annotations

from contextlib import closing
from typing import Any, Generic, Iterator, Optional, TypeVar, Union

import grpc
import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome, RunStatus
from stiefel._results.extras import progress_bar
from stiefel._results.origin import Origin
from stiefel._wire import answers
from stiefel._wire.answers import Layout, ends_at
from stiefel._wire.arrays import decode_fields, named, require
from stiefel._wire.calls import Attempts, Calls
from stiefel.errors import CorruptReply, StiefelError
from stiefel.results import Batch, Events, Summary, Trajectory

T = TypeVar("T")
_OUTCOMES = np.array([name[len("OUTCOME_"):] for name in pb.Outcome.keys()])


class Reading(Generic[T]):
    """Iterates over the parts of a call's answer as they arrive. A stream that breaks is followed by another one, from its last
    checkpoint if the request takes one. The attributes describe what has arrived so far."""

    def __init__(self, handle: Calls, request: Any, timeout: Optional[float], endless: bool = True):
        """`timeout`: the time for all streams together. None: none, or without `endless` that of the client, which begins
        anew with each part that arrives."""
        self._handle, self._request, self._timeout, self._endless = handle, request, timeout, endless
        self._layout = Layout(getattr(request, "fields", ()))
        self.last: Any = None  #: the last message
        self.run_status = RunStatus(Outcome.CANCELLED)  #: that of the answer, at the end
        self.computed_steps = 0  #: steps computed by all streams so far
        self.work = 0.0  #: instructions, measured, of all streams so far
        self.checkpoint: bytes = getattr(request, "checkpoint", b"")  #: the last checkpoint

    def __iter__(self) -> Iterator[T]:
        attempts = Attempts(self._handle, self._request, self._timeout, endless=self._endless)
        method = type(self._request).__name__[:-len("Request")]
        while True:
            before, work = self._begin(), self.work
            try:
                self._handle.prepare(attempts.left())
                with closing(self._handle.messages(method, self._request, attempts.left())) as arriving:
                    for message in arriving:
                        require(message.work > 0, "a message says no work")
                        self._handle.told = getattr(message, "step", self._handle.told)
                        self.work = work + message.work
                        self.computed_steps = max(before + message.computed_steps, self.computed_steps)
                        part = self._take(message)
                        if part is not None:
                            attempts.renew()
                            yield part
                        saved = getattr(message, "checkpoint", pb.Checkpoint())
                        if not hasattr(self._request, "checkpoint"):
                            self._handle.keep(saved.step, saved.data)
                        elif saved.data:
                            self.checkpoint = self._request.checkpoint = saved.data
                            attempts.renew()
                        if message.HasField("run_status"):
                            self.last, self.run_status = message, answers.run_status(message.run_status)
                            self._check_end()
                            return
                raise CorruptReply("the stream ended without saying how the run ended: a part of it is missing")
            except (StiefelError, grpc.RpcError, ValueError) as broken:
                attempts.again(broken)

    def _begin(self) -> int:
        """Prepares the request and the object for another stream. Returns the computed steps that its own are added to."""
        return self.computed_steps

    def _take(self, message: Any) -> Optional[T]:
        """Reads a message, and returns the part of the answer that it completes."""
        raise NotImplementedError

    def _check_end(self) -> None:
        """Checks that all has arrived when the last message has."""
        raise NotImplementedError


class Samples(Reading[Batch]):
    """Iterates over batches of samples: from, from + every, ... and `to`, or the last good step where the run stops."""

    def __init__(self, handle: Calls, request: pb.StreamRequest, step: float, timeout: Optional[float]):
        """`step`: the scene's time between two states."""
        super().__init__(handle, request, timeout, endless=False)
        self._step, self._every = step, request.every or 1
        self._next: int = getattr(request, "from")  #: the step of the next sample
        self._last: Optional[int] = None  #: that of the last one

    def _begin(self) -> int:
        if self._last is not None:  # a stream that goes on after the last sample gives this once more
            self._next = min(self._next, self._request.to)
        setattr(self._request, "from", self._next)
        return super()._begin()

    def _take(self, message: pb.StreamResponse) -> Optional[Batch]:
        """Only the first and the last step are read, because reading repeated numbers one by one would cost more than all the
        fields together. The times of the samples are k · step, which are the engine's bits."""
        count = len(message.steps)
        if not count:
            return None
        steps, last = self._next + self._every * np.arange(count), message.steps[-1]
        require((count == 1 or message.steps[0] == self._next) and 0 <= last <= min(steps[-1], self._request.to)
                and len(message.times) == count, "its samples are not those that come next")
        steps[-1] = last
        self._next = last + self._every
        fields = self._layout.read(message.fields, count)
        if self._last is not None and steps[0] <= self._last:  # the last sample once more
            return None
        self._last = last
        return Batch(steps, steps * self._step, fields)

    def _check_end(self) -> None:
        ends_at(self.run_status, self._last or 0, self._request.to)


class Summarizing(Reading[Union[Events, Batch]]):
    """Iterates over events, or over states at times, of which a request asks for one kind; the summary is available
    afterwards. Nothing is yielded twice."""

    def __init__(self, handle: Calls, request: pb.SummarizeRequest, ensemble: bool, timeout: Optional[float]):
        super().__init__(handle, request, timeout)
        self._ensemble = ensemble
        self.arrays: dict[str, Array] = {}  #: statistics by name, complete at the end
        self._yielded = self._seen = self._kept = 0  # elements: yielded, of this stream, and before the last checkpoint

    def summary(self) -> Summary:
        """Returns the summary. Call it after the iteration has ended. Statistics, "quaternion.last" and others, get the axes of the
        field that the caller gets."""
        quantities: dict[str, dict[str, Array]] = {}
        for name, array in self.arrays.items():
            quantity, dot, statistic = name.rpartition(".")
            if dot:
                behind = int(statistic in ("quantiles", "histogram"))
                quantities.setdefault(quantity, {})[statistic] = named({quantity: array}, behind)[quantity]
        return Summary(quantities, _OUTCOMES[self.arrays["outcome"]], self.arrays["last_step"], self.arrays["ended_by"],
                       self.arrays["samples"], self.run_status, self.computed_steps, self.work, self.checkpoint)

    def _begin(self) -> int:
        """A checkpoint has the number of steps that were computed before it."""
        self._seen = self._kept
        return 0

    def _take(self, message: pb.SummarizeResponse) -> Union[Events, Batch, None]:
        self.arrays.update(decode_fields(message.statistics))
        batch = self._read(message.events if message.HasField("events") else message.states)
        begin, self._seen = self._seen, self._seen + len(batch)
        old, self._yielded = max(self._yielded - begin, 0), max(self._yielded, self._seen)
        if message.HasField("checkpoint"):
            self._kept = self._seen
        return batch[old:] if old < len(batch) else None

    def _read(self, batch: Any) -> Union[Events, Batch]:
        """Returns the events or states of a message."""
        count, steps, times = len(batch.steps), np.array(batch.steps, np.int64), np.array(batch.times)
        fields = self._layout.read(batch.fields, count) if count else {}
        if isinstance(batch, pb.EventBatch):
            require(len(batch.events) == len(batch.fractions) == len(times) == count and len(batch.members) == count * self._ensemble,
                    "its events have lists of different lengths")
            return Events(np.array(batch.events, np.uint32), steps, np.array(batch.fractions), times,
                          np.array(batch.members, np.uint32) if self._ensemble else None, fields)
        require(list(times) == list(self._request.times[self._seen:self._seen + count]), "its states are not at the times asked for")
        return Batch(steps, times, fields)

    def _check_end(self) -> None:
        """Checks that all has come: every state, unless the run stopped or an event may have ended it; statistics of each
        quantity that the request asks for, and how each motion ended."""
        may_end = self.run_status.outcome is not Outcome.REACHED or any(event.terminal for event in self._request.events)
        require(may_end or not self._request.times or self._seen == len(self._request.times), f"it has {self._seen} states")
        wanted = {"outcome", "last_step", "ended_by", "samples", *(quantity.name for quantity in self._request.quantities)}
        require({name.rpartition(".")[0] or name for name in self.arrays} == wanted, f"it has the statistics {', '.join(self.arrays)}")
        outcome = self.arrays["outcome"]
        require(outcome.ndim == self._ensemble and outcome.shape == self.arrays["last_step"].shape
                and set(outcome.flat) <= set(range(1, len(_OUTCOMES))), f"the outcomes are {outcome}")


class Results(Reading[None]):
    """Reads results at steps, and yields nothing. At the end, `at` has the messages with results by step."""

    def __init__(self, handle: Calls, request: Any, timeout: Optional[float], result: str, endless: bool = True):
        """`result`: the field that a message with a result has."""
        super().__init__(handle, request, timeout, endless)
        self._result = result
        self.at: dict[int, Any] = {}

    def _take(self, message: Any) -> None:
        if getattr(message, self._result):
            require(0 <= message.step <= self._request.to, f"it has a result at step {message.step}")
            self.at[message.step] = message

    def _check_end(self) -> None:
        ends_at(self.run_status, self.last.step, self._request.to)
        require(self.run_status.outcome is not Outcome.REACHED or self.last.step in self.at, "its last result is missing")

    def run(self) -> list[Any]:
        """Returns the messages with results in the order of their steps."""
        list(self)
        return [result for _, result in sorted(self.at.items())]


def gathered(reading: Reading[Any], count: int, origin: Origin, progress: bool) -> Trajectory:
    """Returns the samples of a reading, at most `count`, in arrays that are allocated once. An exception has in `partial` those
    that had arrived."""
    done, step, time = 0, np.empty(count, np.int64), np.empty(count)
    fields: dict[str, NDArray[Any]] = {}

    def arrived(run_status: RunStatus) -> Trajectory:
        return Trajectory(step[:done], time[:done], {name: values[:done] for name, values in fields.items()}, run_status,
                          reading.computed_steps, origin)

    try:
        with progress_bar(count, progress, " samples") as bar:
            for batch in reading:
                if not fields:
                    fields = {name: np.empty((count, *part.shape[1:]), part.dtype) for name, part in batch.fields.items()}
                now = slice(done, done + batch.samples)
                step[now], time[now] = batch.step, batch.time
                for name, part in batch.fields.items():
                    fields[name][now] = part
                done = now.stop
                bar.update(batch.samples)
    except StiefelError as error:
        error.partial = arrived(RunStatus(Outcome.CANCELLED, message=error.message))
        raise
    return arrived(reading.run_status)
