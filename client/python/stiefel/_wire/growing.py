"""Reads the stream of a LyapunovSpectrum."""
from __future__ import annotations

from typing import Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._results.base import Outcome
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
        self._kept: list[pb.LyapunovSpectrumResponse] = []  # those with numbers

    def _begin(self) -> int:
        self._seen = -1  # the last step with numbers of this stream
        return self.computed_steps

    def _take(self, message: pb.LyapunovSpectrumResponse) -> None:
        count = len(message.exponents)
        if not count:
            return
        require(len(message.log_gali) == count - 1 and (not self._kept or count == len(self._kept[0].exponents))
                and self._request.count in (0, count), f"it has {count} exponents")
        require(message.step > self._seen, "its results are not in order")
        self._seen = message.step
        if not self._kept or message.step > self._kept[-1].step:
            self._kept.append(message)

    def _check_end(self, message: pb.LyapunovSpectrumResponse) -> None:
        kept, status = self._kept, self.run_status
        count = len(kept[-1].exponents) if kept else 0
        rows = np.reshape([np.array(one.exponents) for one in kept], (len(kept), count))
        volumes = np.reshape([np.array(one.log_gali) for one in kept], (len(kept), max(count - 1, 0)))
        assert status is not None
        ends_at(message.run_status, message.step, self._request.to)
        require(status.outcome != Outcome.REACHED or bool(kept) and kept[-1].step == self._request.to and bool(self.checkpoint)
                and len(message.errors) == count, "its last result is missing")
        require(message.verdict in _VERDICTS, "it has no verdict")
        self.result = LyapunovSpectrum(
            exponents=rows[-1].copy() if kept else np.empty(0), errors=np.array(message.errors),
            verdict=_VERDICTS[message.verdict], reason=message.reason,
            log_gali=volumes[-1].copy() if kept else np.empty(0), step=message.step, time=message.time,
            steps=np.array([one.step for one in kept], np.int64), times=np.array([one.time for one in kept]), history=rows,
            log_gali_history=volumes, interval=message.interval, run_status=status, checkpoint=self.checkpoint,
            computed_steps=self.computed_steps, work=self.work)


_VERDICTS = {pb.VERDICT_UNDECIDED: Verdict.UNDECIDED, pb.VERDICT_REGULAR: Verdict.REGULAR, pb.VERDICT_CHAOTIC: Verdict.CHAOTIC}
