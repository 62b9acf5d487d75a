"""Reads the stream of a LyapunovSpectrum, and begins it anew where it broke."""
from __future__ import annotations

from contextlib import closing
from typing import Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome, Price
from stiefel._wire import replies
from stiefel._wire.recreation import Attempts, Recreation
from stiefel._wire.replies import complete, ends_at, require
from stiefel._wire.retries import Deadline
from stiefel._wire.streams import CheckpointParts
from stiefel.errors import StiefelError
from stiefel.results import LyapunovSpectrum, Verdict


def grown(handle: Recreation, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]) -> LyapunovSpectrum:
    """Returns the result of the call. It depends on the request alone, so a stream that breaks begins anew."""
    attempts = Attempts(handle, Deadline(timeout))
    while True:
        try:
            with handle.explains(request.to):
                return _read(handle, request, attempts.deadline.left())
        except StiefelError as broken:
            error: StiefelError = broken
        attempts.again(error)


def _read(handle: Recreation, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]) -> LyapunovSpectrum:
    steps: list[int] = []
    times: list[float] = []
    rows: list[Array] = []
    volumes: list[Array] = []
    price: Optional[Price] = None
    end: Optional[pb.LyapunovSpectrumResponse] = None
    parts, checkpoint, ignored = CheckpointParts(), b"", False
    with closing(handle.messages("LyapunovSpectrum", request, timeout)) as arriving:
        for message in arriving:
            if price is None:
                price, ignored = replies.price(complete(message, "price").price), message.checkpoint_ignored
            checkpoint = (parts.take(message.checkpoint) if message.HasField("checkpoint") else b"") or checkpoint
            exponents = np.array(message.exponents)
            if exponents.size:
                require(len(message.log_gali) == exponents.size - 1 and (not rows or exponents.size == rows[0].size)
                        and request.count in (0, exponents.size), f"it has {exponents.size} exponents")
                require(not steps or message.step > steps[-1], "its results are not in order")
                steps.append(message.step)
                times.append(message.time)
                rows.append(exponents)
                volumes.append(np.array(message.log_gali))
            if message.HasField("run_status"):
                end = message
                break
    require(end is not None, "it has no end")
    assert end is not None and price is not None
    status = replies.run_status(end.run_status)
    ends_at(end.run_status, end.step, request.to)
    require(status.outcome != Outcome.REACHED or bool(rows) and steps[-1] == request.to and bool(checkpoint)
            and len(end.errors) == rows[-1].size, "its last result is missing")
    require(end.verdict in _VERDICTS and bool(end.reason), "it has no verdict")
    count = rows[-1].size if rows else 0
    return LyapunovSpectrum(
        exponents=rows[-1] if rows else np.empty(0), errors=np.array(end.errors), verdict=_VERDICTS[end.verdict],
        reason=end.reason, log_gali=volumes[-1] if rows else np.empty(0), step=end.step, time=end.time,
        steps=np.array(steps, np.int64), times=np.array(times), history=np.reshape(rows, (len(rows), count)),
        log_gali_history=np.reshape(volumes, (len(rows), max(count - 1, 0))), interval=end.interval, run_status=status,
        checkpoint=checkpoint, checkpoint_ignored=ignored, computed_steps=end.computed_steps, price=price)


_VERDICTS = {pb.VERDICT_UNDECIDED: Verdict.UNDECIDED, pb.VERDICT_REGULAR: Verdict.REGULAR, pb.VERDICT_CHAOTIC: Verdict.CHAOTIC}
