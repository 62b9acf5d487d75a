"""Reads samples from Stream, and resumes the stream where it broke."""
from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING, Iterator, Optional

import numpy as np

from stiefel import calls, recreation
from stiefel import v1 as pb
from stiefel.arrays import Batch, Price, RunStatus, read_steps
from stiefel.assembly import Assembly
from stiefel.checksums import verify_batch
from stiefel.errors import DeadlineExceeded, NotFound, StiefelError, Unavailable
from stiefel.recreation import Recreation
from stiefel.replies import Layout, Steps, complete, require
from stiefel.streams import CheckpointParts, messages

if TYPE_CHECKING:
    from stiefel.client import Client


class Samples:
    """Iterates over batches of whole samples. The attributes describe what has arrived so far."""

    def __init__(self, client: Client, handle: Recreation, request: pb.StreamRequest, step: float,
                 timeout: Optional[float]):
        """`step`: the scene's time between two states. `timeout`: the time for all streams together. If it is None, the
        client's timeout applies, and begins anew when a stream that brought samples is resumed."""
        self._client = client
        self._recreation = handle
        self._request = request
        self._every = request.every
        self._step = step
        self._timeout = timeout
        self.run_status: Optional[RunStatus] = None  #: set after the last batch
        self.computed_steps = 0  #: steps computed by all streams so far
        self.price: Optional[Price] = None  #: the price of the first stream
        self.checkpoint = b""  #: the last complete checkpoint, if the request asks for any
        self._parts = CheckpointParts()
        self._layout = Layout(request.fields, axes=(3, 4))  # samples, in an ensemble members, rows, cols

    def __iter__(self) -> Iterator[Batch]:
        with self._recreation.explains(self._request.to):
            yield from self._batches()

    def _batches(self) -> Iterator[Batch]:
        deadline = calls.Deadline(self._client.deadline(self._timeout))
        waits, recoveries = calls.Pauses(), recreation.pauses()
        last: Optional[int] = None
        before = 0  # steps computed by the streams that broke
        while True:
            if last is not None:
                setattr(self._request, "from", min(last + self._every, self._request.to))
            stream = self._client.stub.Stream(self._request, timeout=deadline.left(), metadata=self._recreation.metadata)
            progress, computed = False, 0
            assembly, self._parts, grid = Assembly(), CheckpointParts(), Steps(self._request)
            try:
                with closing(messages(self._client, self._recreation, stream)) as arriving:
                    for message in arriving:
                        computed = max(computed, message.computed_steps)
                        self.computed_steps = before + computed
                        batch = self._read(message, assembly)
                        if batch is not None:
                            grid.check(batch.step)
                        if batch is not None and (last is None or batch.step[0] > last):
                            progress, last = True, int(batch.step[-1])
                            yield batch
                        if self.run_status is not None:
                            require(not assembly.begun, "the last sample is incomplete")
                            grid.end(self.run_status, last)
                            return
            except StiefelError as broken:
                error: StiefelError = broken
            before += computed
            if progress and isinstance(error, Unavailable if self._timeout is not None else (DeadlineExceeded, Unavailable)):
                waits, recoveries = calls.Pauses(), recreation.pauses()
                if self._timeout is None:
                    deadline = calls.Deadline(self._client.deadline(None))
                if not (self._recreation.has_checkpoint and self._recreation.is_gone(error)):
                    continue
                # The next server may have held the session long ago, so it gets the checkpoint first.
                self._recreation.recover(error, recoveries, deadline)
                continue
            try:
                calls.pause_or_raise(error, waits, self._client, deadline, late=True)
            except (NotFound, Unavailable) as lost:
                self._recreation.recover(lost, recoveries, deadline)

    def _read(self, message: pb.StreamResponse, assembly: Assembly) -> Optional[Batch]:
        """Reads a message and returns the samples that it completes, None if there are none."""
        steps = read_steps(message, self._every) if message.steps else np.empty(0, np.int64)
        times = steps * self._step
        verify_batch(message, steps.tobytes(), times.tobytes(), self._request.checksum)
        if self.price is None:
            self.price = Price.of(complete(message, "price").price)
        if message.HasField("run_status"):
            self.run_status = RunStatus.of(message.run_status)
        if message.HasField("checkpoint"):
            whole = self._parts.take(message.checkpoint)
            if whole:
                self.checkpoint = whole
                self._recreation.keep(message.checkpoint.step, whole)
        if not message.steps:
            return None
        assembly.take(message.fields)
        if message.sample_continues:
            return None
        fields = assembly.finish()
        self._layout.check(fields, len(steps))
        return Batch(steps, times, fields)
