"""Reads the stream of a Summarize."""
from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np

from stiefel import v1 as pb
from stiefel._results.base import Array
from stiefel._wire import answers
from stiefel._wire.arrays import decode_fields, named
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import Layout, require
from stiefel._wire.streams import Reading
from stiefel.results import Batch, Events, Summary


class Summarizing(Reading[Union[Events, Batch]]):
    """Iterates over events, or over states at times, of which a request asks for one kind; the summary is available
    afterwards. Nothing is yielded twice."""

    def __init__(self, handle: Recreation, request: pb.SummarizeRequest, ensemble: bool, timeout: Optional[float]):
        super().__init__(handle, request, timeout)
        self._ensemble = ensemble
        self._layout = Layout(request.fields)
        self.arrays: dict[str, Array] = {}  #: statistics by name, complete at the end
        self._yielded = self._seen = self._kept = 0  # elements: yielded, of this stream, and before the last checkpoint

    def summary(self) -> Summary:
        """Returns the summary. Call it after the iteration has ended."""
        return answers.summary(self.arrays, self.run_status, self.computed_steps, self.work, self.checkpoint)

    def _begin(self) -> int:
        """A checkpoint has the number of steps that were computed before it."""
        self._seen = self._kept
        return 0

    def _take(self, message: pb.SummarizeResponse) -> Union[Events, Batch, None]:
        self.arrays.update(decode_fields(message.statistics))
        if not message.HasField("events") and not message.HasField("states"):
            return None
        batch = self._read(message.events if message.HasField("events") else message.states)
        begin, self._seen = self._seen, self._seen + len(batch)
        old, self._yielded = max(self._yielded - begin, 0), max(self._yielded, self._seen)
        return batch[old:] if old < len(batch) else None

    def _keep(self, message: pb.SummarizeResponse) -> None:
        self._kept = self._seen

    def _read(self, batch: Any) -> Union[Events, Batch]:
        """Returns the events or states of a message."""
        fields, count = decode_fields(batch.fields), len(batch.steps)
        self._layout.check(fields, count)
        if isinstance(batch, pb.EventBatch):
            events = answers.events(batch, named(fields), self._ensemble)
            require(len({len(one) for one in (events.event, events.step, events.fraction, events.time)}) == 1
                    and (events.member is None or len(events.member) == count), "its events have lists of different lengths")
            return events
        require(list(batch.times) == list(self._request.times[self._seen:self._seen + count]), "its states are not at the times asked for")
        return Batch(np.array(batch.steps, np.int64), np.array(batch.times), named(fields))

    def _check_end(self, message: pb.SummarizeResponse) -> None:
        """Checks that all has come: every state, unless the run stopped or an event may have ended it, and the
        statistics."""
        may_end = message.run_status.outcome != pb.OUTCOME_REACHED or any(event.terminal for event in self._request.events)
        require(may_end or not self._request.times or self._seen == len(self._request.times), f"it has {self._seen} states")
        answers.check_statistics(self.arrays, self._request, self._ensemble)
