"""Reads the streams of a LyapunovSpectrum, which go on where they broke."""
from __future__ import annotations

from contextlib import closing
from typing import Any, Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome, Price
from stiefel._wire import replies
from stiefel._wire.recreating import Attempts, Recreation, refuses_checkpoint
from stiefel._wire.replies import complete, ends_at, require
from stiefel._wire.retries import Deadline
from stiefel._wire.streams import CheckpointParts
from stiefel.errors import CorruptReply, StiefelError
from stiefel.results import LyapunovSpectrum, Verdict


def grown(handle: Recreation, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]) -> LyapunovSpectrum:
    """Returns the result of the call. A stream that breaks goes on from the last checkpoint that came, or begins anew."""
    attempts, reading = Attempts(handle, Deadline(timeout)), _Reading(request)
    given = request.checkpoint  # the caller's
    while True:
        try:
            with handle.explains(request.to), closing(handle.messages("LyapunovSpectrum", reading.request,
                                                                      attempts.deadline.left())) as arriving:
                for message in arriving:
                    if reading.takes_checkpoint(message):
                        attempts.renew()
                    if message.HasField("run_status"):
                        return reading.result(message)
            raise CorruptReply("the reply breaks the protocol: it has no end")
        except StiefelError as broken:
            error: StiefelError = broken
        reading.broke()
        if reading.request.checkpoint != given and refuses_checkpoint(error):
            reading.request.checkpoint = given  # this server has another build
            continue
        attempts.again(error)


class _Reading:
    """The numbers of the streams of one call, each of which is read once."""

    def __init__(self, request: pb.LyapunovSpectrumRequest):
        self.request = request
        self._parts, self._checkpoint = CheckpointParts(), b""
        self._steps: list[int] = []
        self._times: list[float] = []
        self._rows: list[Array] = []
        self._volumes: list[Array] = []
        self._price: Optional[Price] = None
        self._priced = False
        self._before = self._computed = 0  # the steps that broken streams computed, and this one
        self._seen = -1  # the last step with numbers of this stream

    def broke(self) -> None:
        self._before += self._computed
        self._computed, self._seen, self._priced, self._parts = 0, -1, False, CheckpointParts()

    def takes_checkpoint(self, message: pb.LyapunovSpectrumResponse) -> bool:
        """Reads a message, and returns whether a new stream can begin where a checkpoint in it was taken."""
        if not self._priced:
            price, self._priced = replies.price(complete(message, "price").price), True
            if self._price is None:
                self._price = price
        self._computed = message.computed_steps
        exponents = np.array(message.exponents)
        if exponents.size:
            require(len(message.log_gali) == exponents.size - 1 and (not self._rows or exponents.size == self._rows[0].size)
                    and self.request.count in (0, exponents.size), f"it has {exponents.size} exponents")
            require(message.step > self._seen, "its results are not in order")
            self._seen = message.step
            if not self._steps or message.step > self._steps[-1]:
                self._steps.append(message.step)
                self._times.append(message.time)
                self._rows.append(exponents)
                self._volumes.append(np.array(message.log_gali))
        whole = self._parts.take(message.checkpoint) if message.HasField("checkpoint") else b""
        self._checkpoint = whole or self._checkpoint
        if not whole or message.HasField("run_status"):
            return False
        self.request.checkpoint = whole
        return True

    def result(self, end: pb.LyapunovSpectrumResponse) -> LyapunovSpectrum:
        rows, volumes, steps = self._rows, self._volumes, self._steps
        assert self._price is not None
        status = replies.run_status(end.run_status)
        ends_at(end.run_status, end.step, self.request.to)
        require(status.outcome != Outcome.REACHED or bool(rows) and steps[-1] == self.request.to and bool(self._checkpoint)
                and len(end.errors) == rows[-1].size, "its last result is missing")
        require(end.verdict in _VERDICTS and bool(end.reason), "it has no verdict")
        count = rows[-1].size if rows else 0
        return LyapunovSpectrum(
            exponents=rows[-1] if rows else np.empty(0), errors=np.array(end.errors), verdict=_VERDICTS[end.verdict],
            reason=end.reason, log_gali=volumes[-1] if rows else np.empty(0), step=end.step, time=end.time,
            steps=np.array(steps, np.int64), times=np.array(self._times), history=np.reshape(rows, (len(rows), count)),
            log_gali_history=np.reshape(volumes, (len(rows), max(count - 1, 0))), interval=end.interval, run_status=status,
            checkpoint=self._checkpoint, computed_steps=self._before + end.computed_steps, price=self._price)


_VERDICTS = {pb.VERDICT_UNDECIDED: Verdict.UNDECIDED, pb.VERDICT_REGULAR: Verdict.REGULAR, pb.VERDICT_CHAOTIC: Verdict.CHAOTIC}
