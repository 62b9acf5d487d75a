"""Reads samples from Stream."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import RunStatus
from stiefel._results.origin import Origin
from stiefel._wire.arrays import decode_fields, named
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import Layout, Steps
from stiefel._wire.streams import Reading
from stiefel.results import Batch, Trajectory


class Samples(Reading[Batch]):
    """Iterates over batches of samples."""

    method, endless = "Stream", False

    def __init__(self, handle: Recreation, request: pb.StreamRequest, step: float, timeout: Optional[float], blocks: int = 0):
        """`step`: the scene's time between two states. `blocks`: as of Layout."""
        super().__init__(handle, request, timeout)
        self._step = step
        self._last: Optional[int] = None
        self._layout = Layout(request.fields, axes=(3, 4), blocks=blocks)  # samples, in an ensemble members, rows, cols

    def _begin(self) -> int:
        if self._last is not None:
            setattr(self._request, "from", min(self._last + self._request.every, self._request.to))
        self._grid = Steps(self._request)
        return self.computed_steps

    def _take(self, message: pb.StreamResponse) -> Optional[Batch]:
        """The times of the samples are k · step, which are the engine's bits."""
        if not message.steps:
            return None
        steps, fields = self._grid.take(message), decode_fields(message.fields)
        self._layout.check(fields, len(steps))
        if self._last is not None and steps[0] <= self._last:  # the last sample once more
            return None
        self._last = int(steps[-1])
        return Batch(steps, steps * self._step, named(fields))

    def _keep(self, message: pb.StreamResponse, ends: bool) -> bool:
        self._handle.keep(message.checkpoint.step, self.checkpoint)
        return False

    def _check_end(self, message: pb.StreamResponse) -> None:
        assert self.run_status is not None
        self._grid.end(self.run_status, self._last)


class Collector:
    """Joins batches in arrays that are allocated once, for at most `count` samples."""

    def __init__(self, count: int, origin: Origin):
        self._count, self._origin = count, origin
        self._done = 0
        self._step, self._time = np.empty(count, np.int64), np.empty(count)
        self._fields: dict[str, NDArray[Any]] = {}

    def add(self, batch: Batch) -> None:
        if not self._fields:
            self._fields = {name: np.empty((self._count, *part.shape[1:]), part.dtype) for name, part in batch.fields.items()}
        now = slice(self._done, self._done + batch.samples)
        self._step[now], self._time[now] = batch.step, batch.time
        for name, part in batch.fields.items():
            self._fields[name][now] = part
        self._done = now.stop

    def trajectory(self, run_status: RunStatus, computed_steps: int) -> Trajectory:
        """Returns all samples that were added."""
        done = slice(self._done)
        return Trajectory(self._step[done], self._time[done], {name: values[done] for name, values in self._fields.items()},
                          run_status, computed_steps, self._origin)
