"""Reads the stream of a Linearize."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._given.numbers import numbers, refused, step_index
from stiefel._given.when import steps_of
from stiefel._results.base import Array, Outcome
from stiefel._results.body import principal
from stiefel._wire.arrays import decode_fields, set_tensor
from stiefel._wire.recreating import Recreation
from stiefel._wire.replies import ends_at, require
from stiefel._wire.streams import Reading
from stiefel.errors import FailedPrecondition
from stiefel.results import StateTransition


def put_vectors(request: pb.LinearizeRequest, vectors: Any) -> None:
    """Sets the tangent vectors: (d) or (m, d) by coordinates, (m, rows, cols) as blocks."""
    if vectors is None:
        return
    given = numbers("vectors", vectors)
    if given.ndim not in (1, 2, 3) or not given.size:
        raise refused("vectors", f"the shape {given.shape}: must be (m, d) or (m, rows, cols)")
    set_tensor(request.vectors, given if given.ndim > 1 else given[np.newaxis])


def linearized(handle: Recreation, request: pb.LinearizeRequest, step: float, timeout: Optional[float]) -> StateTransition:
    """Returns the results of the call. `step`: the scene's time between two states."""
    transition = _Transition(handle, request, step, timeout)
    for _ in transition:
        pass
    return transition.result


def covariance(session: Any, P0: Any, to: Optional[int], start: int, every: int, timeout: Optional[float], time: Any,
               rates: bool, times: Any) -> Array:
    """Does what `Session.covariance` says."""
    given, scene = numbers("P0", P0), session._resolved()
    which: Any = slice(None)
    if times is not None:
        for name, value in (("to", to), ("time", time), ("every", every or None)):
            if value is not None:
                raise refused(name, f"{value!r}: must be absent where `times` are given")
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


class _Transition(Reading[None]):
    """Yields nothing; `result` is there at the end. The vectors at a step depend on the request alone, so a stream that breaks
    begins anew."""

    method, endless = "Linearize", False
    result: StateTransition

    def __init__(self, handle: Recreation, request: pb.LinearizeRequest, step: float, timeout: Optional[float]):
        super().__init__(handle, request, timeout)
        self._step = step

    def _begin(self) -> int:
        self._steps: list[int] = []
        self._results: list[dict[str, Array]] = []
        return self.computed_steps

    def _take(self, message: pb.LinearizeResponse) -> None:
        require(bool(message.fields) or message.HasField("run_status"), "a message is empty")
        if message.fields:
            require(not self._steps or message.step > self._steps[-1], "its results are not in order")
            self._steps.append(message.step)
            self._results.append(decode_fields(message.fields))

    def _check_end(self, message: pb.LinearizeResponse) -> None:
        request, steps, results, status = self._request, self._steps, self._results, self.run_status
        assert status is not None
        ends_at(message.run_status, message.step, request.to)
        require(status.outcome != Outcome.REACHED or (bool(steps) and steps[-1] == request.to), "its last result is missing")
        for result in results:
            _check_shape(request, result, results[0])
        alone = request.every == 0 and len(results) == 1

        def stacked(which: str) -> Optional[Array]:
            if not results or which not in results[0]:
                return None
            arrays = [result[which] for result in results]
            return arrays[0] if alone else np.stack(arrays)

        reached = np.array(steps, np.int64)
        if alone:
            reached = reached[0]
        self.result = StateTransition(
            step=reached, time=reached * self._step,
            matrix=stacked("matrix"), vectors=stacked("vectors"), basis=stacked("basis"),
            start_basis=results[0].get("start_basis") if results else None,
            parameters=("inertia",) * request.inertia + ("step",) * request.step,
            run_status=status, computed_steps=self.computed_steps, work=self.work)


def _check_shape(request: pb.LinearizeRequest, result: dict[str, Array], first: dict[str, Array]) -> None:
    """Checks that a result has a column for every vector and every parameter, and a row for every coordinate."""
    given = tuple(request.vectors.shape)
    name = "vectors" if len(given) == 3 else "matrix"
    require(name in result and result[name].ndim == (3 if name == "vectors" else 2), f"a result has no {name}")
    shape, like = result[name].shape, first[name].shape
    require(shape == like, f"its {name} have the shapes {shape} and {like}")
    if name == "vectors":
        count, asked = shape[0], given[0]
        require(shape[1:] == given[1:], f"its vectors have the shape {shape}")
    else:
        basis, start = result.get("basis", np.empty(0)), first.get("start_basis", np.empty(0))
        count, asked = shape[1], given[0] if given else len(start)
        require(start.ndim == 3 and basis.shape == (shape[0], *start.shape[1:]), f"its matrix has the shape {shape}")
    extra = count - asked
    require(extra == request.step if not request.inertia else extra > request.step, f"it has {extra} parameters")
