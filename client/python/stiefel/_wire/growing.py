"""Reads the stream of a LyapunovSpectrum."""
from __future__ import annotations

from typing import Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._results.base import Array, Outcome
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import ends_at, require
from stiefel._wire.streams import Resuming
from stiefel.results import LyapunovSpectrum, Verdict


def grown(handle: Recreation, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]) -> LyapunovSpectrum:
    """Returns the result of the call."""
    growth = _Growth(handle, request, timeout)
    for _ in growth:
        pass
    return growth.result


class _Growth(Resuming[None]):
    """Yields nothing; `result` is there at the end. The numbers at a step are read once, whatever streams send them."""

    method = "LyapunovSpectrum"
    result: LyapunovSpectrum

    def __init__(self, handle: Recreation, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]):
        super().__init__(handle, request, timeout)
        self.checkpoint = b""  # the caller's is no result
        self._steps: list[int] = []
        self._times: list[float] = []
        self._rows: list[Array] = []
        self._volumes: list[Array] = []

    def _begin(self) -> int:
        self._seen = -1  # the last step with numbers of this stream
        return self.computed_steps

    def _take(self, message: pb.LyapunovSpectrumResponse) -> None:
        exponents = np.array(message.exponents)
        if not exponents.size:
            return
        require(len(message.log_gali) == exponents.size - 1 and (not self._rows or exponents.size == self._rows[0].size)
                and self._request.count in (0, exponents.size), f"it has {exponents.size} exponents")
        require(message.step > self._seen, "its results are not in order")
        self._seen = message.step
        if not self._steps or message.step > self._steps[-1]:
            self._steps.append(message.step)
            self._times.append(message.time)
            self._rows.append(exponents)
            self._volumes.append(np.array(message.log_gali))

    def _check_end(self, message: pb.LyapunovSpectrumResponse) -> None:
        rows, volumes, steps, status = self._rows, self._volumes, self._steps, self.run_status
        assert status is not None
        ends_at(message.run_status, message.step, self._request.to)
        require(status.outcome != Outcome.REACHED or bool(rows) and steps[-1] == self._request.to and bool(self.checkpoint)
                and len(message.errors) == rows[-1].size, "its last result is missing")
        require(message.verdict in _VERDICTS, "it has no verdict")
        count = rows[-1].size if rows else 0
        self.result = LyapunovSpectrum(
            exponents=rows[-1] if rows else np.empty(0), errors=np.array(message.errors), verdict=_VERDICTS[message.verdict],
            reason=message.reason, log_gali=volumes[-1] if rows else np.empty(0), step=message.step, time=message.time,
            steps=np.array(steps, np.int64), times=np.array(self._times), history=np.reshape(rows, (len(rows), count)),
            log_gali_history=np.reshape(volumes, (len(rows), max(count - 1, 0))), interval=message.interval, run_status=status,
            checkpoint=self.checkpoint, computed_steps=self.computed_steps,
            work=self.work)

_VERDICTS = {pb.VERDICT_UNDECIDED: Verdict.UNDECIDED, pb.VERDICT_REGULAR: Verdict.REGULAR, pb.VERDICT_CHAOTIC: Verdict.CHAOTIC}
