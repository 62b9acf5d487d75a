"""What is read from Linearize and LyapunovSpectrum: results at steps, whatever streams send them."""
from __future__ import annotations

from typing import Any, Callable, Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._given.numbers import numbers, refused, step_index
from stiefel._given.when import steps_of
from stiefel._results.base import Array, Outcome
from stiefel._results.body import principal
from stiefel._wire.arrays import decode_fields, set_tensor
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import Layout, ends_at, name_of, require
from stiefel._wire.streams import Reading
from stiefel._wire.times import absent_with_times
from stiefel.errors import FailedPrecondition
from stiefel.results import LyapunovSpectrum, StateTransition, Verdict


class _Results(Reading[None]):
    """Yields nothing; at the end, `at` has what `read` makes of the messages with results, by step, and `last` is the last
    message."""

    last: Any

    def __init__(self, handle: Recreation, request: Any, timeout: Optional[float], read: Callable[[Any], Any],
                 endless: bool = True):
        """`read`: returns nothing that is true for a message without a result."""
        super().__init__(handle, request, timeout)
        self._read, self.endless = read, endless
        self.at: dict[int, Any] = {}

    def _take(self, message: Any) -> None:
        result = self._read(message)
        if result:
            require(0 <= message.step <= self._request.to, f"it has a result at step {message.step}")
            self.at[message.step] = result

    def _check_end(self, message: Any) -> None:
        ends_at(message.run_status, message.step, self._request.to)
        require(message.run_status.outcome != pb.OUTCOME_REACHED or message.step in self.at, "its last result is missing")
        self.last = message

    def run(self) -> list[Any]:
        """Returns the results in the order of their steps."""
        for _ in self:
            pass
        return [result for _, result in sorted(self.at.items())]


def put_vectors(request: pb.LinearizeRequest, vectors: Any) -> None:
    """Sets the tangent vectors: (d) or (m, d) by coordinates, (m, rows, cols) as blocks."""
    if vectors is None:
        return
    given = numbers("vectors", vectors)
    if given.ndim not in (1, 2, 3) or not given.size:
        raise refused("vectors", f"the shape {given.shape}: must be (m, d) or (m, rows, cols)")
    set_tensor(request.vectors, given if given.ndim > 1 else given[np.newaxis])


def linearized(handle: Recreation, request: pb.LinearizeRequest, step: float, timeout: Optional[float]) -> StateTransition:
    """Returns the results of the call. `step`: the scene's time between two states. A stream that breaks begins anew, because
    the vectors at a step depend on the request alone."""
    reading = _Results(handle, request, timeout, lambda message: decode_fields(message.fields), endless=False)
    results = reading.run()
    steps, alone = np.array(sorted(reading.at), np.int64), request.every == 0 and len(results) == 1
    start_basis, layout = results[0].pop("start_basis", None) if results else None, Layout([])
    for result in results:
        layout.check(result)
        require(("vectors" if len(request.vectors.shape) == 3 else "matrix") in result, "a result has no vectors")

    def stacked(which: str) -> Optional[Array]:
        arrays = [result[which] for result in results if which in result]
        return (arrays[0] if alone else np.stack(arrays)) if arrays else None

    return StateTransition(
        step=steps[0] if alone else steps, time=(steps[0] if alone else steps) * step, matrix=stacked("matrix"), vectors=stacked("vectors"),
        basis=stacked("basis"), start_basis=start_basis, parameters=("inertia",) * request.inertia + ("step",) * request.step,
        run_status=reading.run_status, computed_steps=reading.computed_steps, work=reading.work)


def covariance(session: Any, P0: Any, to: Optional[int], start: int, every: int, timeout: Optional[float], time: Any,
               rates: bool, times: Any) -> Array:
    """Does what `Session.covariance` says."""
    given, scene = numbers("P0", P0), session._resolved()
    which: Any = slice(None)
    if times is not None:
        absent_with_times(to=to, time=time, every=every or None)
        after = steps_of(times, scene.step, session.epoch) - step_index("start", start)
        if after.min() < 0:
            raise refused("times", f"{float(after.min() + start) * scene.step!r}: is before step {start}, where P0 is given")
        every = int(np.gcd.reduce(after)) or 1
        to, which = int(after.max()) + start, after // every
    moved = session.linearize(to, start=start, every=every, timeout=timeout, time=time)
    if moved.outcome is not Outcome.REACHED:
        raise FailedPrecondition(f"the step cannot be reached: {moved.run_status.message}")
    Phi, size = moved.matrix, moved.matrix.shape[-1]
    if given.shape != (size, size):
        raise refused("P0", f"the shape {given.shape}: must be ({size}, {size})")
    if not np.isfinite(given).all():
        raise refused("P0", f"{given[~np.isfinite(given)][0]}: must be finite")
    if rates:
        if size != 6 or scene.system not in ("rigid_body", "right_rigid_body", "moser_veselov"):
            raise refused("rates", f"True: must be False, because {scene.system} has no attitude and momentum of a body in 3D")
        momentum = np.eye(6)
        momentum[3:, 3:] = principal(session.scene, None).momentum(np.eye(3))
        Phi = np.linalg.solve(momentum, Phi @ momentum)
    return np.asarray((Phi @ given @ np.swapaxes(Phi, -1, -2))[which])


def grown(handle: Recreation, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]) -> LyapunovSpectrum:
    """Returns the result of the call."""
    reading = _Results(handle, request, timeout, lambda message: message if message.exponents else None)
    kept, last = reading.run(), reading.last
    count = len(kept[0].exponents) if kept else 0
    require(request.count in (0, count) or not kept, f"it has {count} exponents")
    require(all(len(one.exponents) == count and len(one.log_gali) == count - 1 for one in kept), "its results have other numbers")
    rows = np.reshape([np.array(one.exponents) for one in kept], (len(kept), count))
    volumes = np.reshape([np.array(one.log_gali) for one in kept], (len(kept), max(count - 1, 0)))
    return LyapunovSpectrum(
        exponents=rows[-1].copy() if kept else np.empty(0), errors=np.array(last.errors),
        verdict=Verdict(name_of(pb.Verdict, last.verdict).lower()), reason=last.reason,
        log_gali=volumes[-1].copy() if kept else np.empty(0), step=last.step, time=last.time,
        steps=np.array([one.step for one in kept], np.int64), times=np.array([one.time for one in kept]), history=rows,
        log_gali_history=volumes, interval=last.interval, run_status=reading.run_status, checkpoint=reading.checkpoint,
        computed_steps=reading.computed_steps, work=reading.work)
