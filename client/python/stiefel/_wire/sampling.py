"""Reads samples from Stream."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import Outcome, RunStatus
from stiefel._results.origin import Origin
from stiefel._wire.arrays import decode_fields, named
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import Layout, ends_at, require
from stiefel._wire.streams import Reading, progress_bar
from stiefel.errors import StiefelError
from stiefel.results import Batch, Trajectory


class Samples(Reading[Batch]):
    """Iterates over batches of samples: from, from + every, ... and `to`, or the last good step where the run stops."""

    endless = False

    def __init__(self, handle: Recreation, request: pb.StreamRequest, step: float, timeout: Optional[float]):
        """`step`: the scene's time between two states."""
        super().__init__(handle, request, timeout)
        self._step = step
        self._every = request.every or 1
        self._next: int = getattr(request, "from")  #: the step of the next sample
        self._last: Optional[int] = None  #: that of the last one
        self._layout = Layout(request.fields)

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
        fields = decode_fields(message.fields)
        self._layout.check(fields, count)
        if self._last is not None and steps[0] <= self._last:  # the last sample once more
            return None
        self._last = last
        return Batch(steps, steps * self._step, named(fields))

    def _keep(self, message: pb.StreamResponse) -> None:
        self._handle.keep(message.checkpoint.step, self.checkpoint)

    def _check_end(self, message: pb.StreamResponse) -> None:
        ends_at(message.run_status, self._last or 0, self._request.to)


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
