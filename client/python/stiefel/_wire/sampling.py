"""Reads samples from Stream, and resumes the stream where it broke."""
from __future__ import annotations

from contextlib import closing
from typing import Any, Iterator, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import Price, RunStatus
from stiefel._results.origin import Origin
from stiefel._wire import replies
from stiefel._wire.arrays import Assembly, named
from stiefel._wire.recreating import Attempts, Recreation
from stiefel._wire.replies import Layout, Steps, complete, require
from stiefel._wire.streams import CheckpointParts
from stiefel.errors import DeadlineExceeded, StiefelError, Unavailable
from stiefel.results import Batch, Trajectory


class Samples:
    """Iterates over batches of whole samples. The attributes describe what has arrived so far."""

    def __init__(self, handle: Recreation, request: pb.StreamRequest, step: float, timeout: Optional[float], blocks: int = 0):
        """`step`: the scene's time between two states. `timeout`: the time for all streams together. If it is None, the
        client's timeout applies, and begins anew when a stream that brought samples is resumed. `blocks`: as of Layout."""
        self._handle = handle
        self._request = request
        self._every = request.every
        self._step = step
        self._timeout = timeout
        self.run_status: Optional[RunStatus] = None  #: set after the last batch
        self.computed_steps = 0  #: steps computed by all streams so far
        self.price: Optional[Price] = None  #: the price of the first stream
        self.checkpoint = b""  #: the last complete checkpoint, if the request asks for any
        self._parts = CheckpointParts()
        self._layout = Layout(request.fields, axes=(3, 4), blocks=blocks)  # samples, in an ensemble members, rows, cols

    def __iter__(self) -> Iterator[Batch]:
        with self._handle.explains(self._request.to):
            yield from self._batches()

    def _batches(self) -> Iterator[Batch]:
        attempts = Attempts(self._handle, self._handle.connection.deadline(self._timeout))
        last: Optional[int] = None
        before = 0  # steps computed by the streams that broke
        while True:
            if last is not None:
                setattr(self._request, "from", min(last + self._every, self._request.to))
            progress, computed = False, 0
            assembly, self._parts, grid = Assembly(), CheckpointParts(), Steps(self._request)
            try:
                with closing(self._handle.messages("Stream", self._request, attempts.deadline.left())) as arriving:
                    for message in arriving:
                        computed = max(computed, message.computed_steps)
                        self.computed_steps = before + computed
                        batch = self._read(message, assembly, grid)
                        if batch is not None and (last is None or batch.step[0] > last):
                            progress, last = True, int(batch.step[-1])
                            yield batch
                        if self.run_status is not None:
                            require(not assembly.begun, "the last sample is incomplete")
                            grid.end(self.run_status, last)
                            return
            except StiefelError as broken:
                error: StiefelError = broken
            else:
                raise AssertionError("a stream ends with an exception")
            before += computed
            passing = Unavailable if self._timeout is not None else (DeadlineExceeded, Unavailable)
            if progress and (isinstance(error, passing) or error._may_pass):
                attempts.renew()
                if self._timeout is None:
                    attempts.deadline = self._handle.connection.deadline(None)
                if self._handle.has_checkpoint and self._handle.is_gone(error):
                    # The next server may have held the session long ago, so it gets the checkpoint first.
                    attempts.recover(error)
                continue
            attempts.again(error)

    def _read(self, message: pb.StreamResponse, assembly: Assembly, grid: Steps) -> Optional[Batch]:
        """Reads a message and returns the samples that it completes, None if there are none. Their times are k · step,
        which are the engine's bits."""
        if self.price is None:
            self.price = replies.price(complete(message, "price").price)
        if message.HasField("run_status"):
            self.run_status = replies.run_status(message.run_status)
        if message.HasField("checkpoint"):
            whole = self._parts.take(message.checkpoint)
            if whole:
                self.checkpoint = whole
                self._handle.keep(message.checkpoint.step, whole)
        if not message.steps:
            return None
        assembly.take(message.fields)
        if message.sample_continues:
            return None
        steps, fields = grid.take(message), assembly.finish()
        self._layout.check(fields, len(steps))
        return Batch(steps, steps * self._step, named(fields))


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
