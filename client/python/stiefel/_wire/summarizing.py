"""Reads the stream of a Summarize."""
from __future__ import annotations

import dataclasses
from typing import Any, Optional, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome, RunStatus
from stiefel._results.origin import Origin
from stiefel._wire import answers
from stiefel._wire.arrays import decode_fields, named
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import Layout, require
from stiefel._wire.sampling import Collector
from stiefel._wire.streams import Resuming, progress_bar
from stiefel.errors import StiefelError
from stiefel.results import Batch, Events, Summary, Trajectory


class Summarizing(Resuming[Union[Events, Batch]]):
    """Iterates over events, or over states at times, of which a request asks for one kind; the summary is available
    afterwards. Nothing is yielded twice."""

    method = "Summarize"

    def __init__(self, handle: Recreation, request: pb.SummarizeRequest, ensemble: bool, timeout: Optional[float],
                 blocks: int = 0):
        """`blocks`: as of Layout."""
        super().__init__(handle, request, timeout)
        self._ensemble = ensemble
        self._layout = Layout(request.fields, (3,) if request.events else (3, 4), blocks)
        self.arrays: dict[str, Array] = {}  #: statistics by name, complete at the end
        self._yielded = self._seen = self._kept = 0  # elements: yielded, of this stream, and before the last checkpoint
        self._recounted = 0  # computed steps before the last checkpoint, which the next stream counts again

    def summary(self) -> Summary:
        """Returns the summary. Call it after the iteration has ended."""
        assert self.run_status is not None
        return answers.summary(self.arrays, self.run_status, self.computed_steps, self.work, self.checkpoint)

    def _begin(self) -> int:
        self._seen = self._kept
        return max(self.computed_steps - self._recounted, 0)

    def _take(self, message: pb.SummarizeResponse) -> Union[Events, Batch, None]:
        self.arrays.update(decode_fields(message.statistics))
        batch = self._read(message)
        if batch is None:
            return None
        begin, self._seen = self._seen, self._seen + len(batch)
        old, self._yielded = max(self._yielded - begin, 0), max(self._yielded, self._seen)
        return batch[old:] if old < len(batch) else None

    def _keep(self, message: pb.SummarizeResponse, ends: bool) -> bool:
        self._kept, self._recounted = self._seen, message.computed_steps
        return super()._keep(message, ends)

    def _begins_anew(self, error: StiefelError) -> bool:
        anew = super()._begins_anew(error)
        if anew:
            self._kept = self._recounted = 0
        return anew

    def _read(self, message: pb.SummarizeResponse) -> Union[Events, Batch, None]:
        """Returns the events or states of a message."""
        of_events = message.HasField("events")
        if not of_events and not message.HasField("states"):
            return None
        batch: Any = message.events if of_events else message.states
        lists = [batch.steps, batch.times]
        if of_events:
            lists += [batch.events, batch.fractions, *([batch.members] if self._ensemble else [])]
            require(all(event < len(self._request.events) for event in batch.events), "it has an unknown event")
        require(len({*map(len, lists)}) == 1, "its events or states have lists of different lengths")
        fields = decode_fields(batch.fields)
        self._layout.check(fields, len(batch.steps))
        if of_events:
            return answers.events(batch, named(fields), self._ensemble)
        asked = self._request.times[self._seen:self._seen + len(batch.times)]
        require(list(asked) == list(batch.times), "its states are not at the times asked for")
        return Batch(np.array(batch.steps, np.int64), np.array(batch.times), named(fields))

    def _check_end(self, message: pb.SummarizeResponse) -> None:
        """Checks that all has come: every state, unless the run stopped or an event may have ended it, and the
        statistics."""
        assert self.run_status is not None
        may_end = self.run_status.outcome != Outcome.REACHED or any(event.terminal for event in self._request.events)
        require(may_end or not self._request.times or self._seen == len(self._request.times), f"it has {self._seen} states")
        answers.check_statistics(self.arrays, self._request, self._ensemble)
        self.arrays = answers.named_statistics(self.arrays)


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
