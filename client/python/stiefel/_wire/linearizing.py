"""Reads the stream of a Linearize, and begins it anew where it broke."""
from __future__ import annotations

from contextlib import closing
from typing import Any, Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._given.numbers import numbers, refused, step_index
from stiefel._given.when import steps_of
from stiefel._results.base import Array, Outcome, Price, RunStatus
from stiefel._results.body import principal
from stiefel._wire import replies
from stiefel._wire.arrays import Assembly, set_tensor
from stiefel._wire.recreating import Attempts, Recreation
from stiefel._wire.replies import complete, ends_at, require
from stiefel.errors import FailedPrecondition, StiefelError
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
    """Returns the results of the call. The vectors at a step depend on the request alone, so a stream that breaks begins
    anew. `step`: the scene's time between two states."""
    attempts = Attempts(handle, handle.connection.deadline(timeout))
    while True:
        try:
            with handle.explains(request.to):
                return _read(handle, request, step, attempts.deadline.left())
        except StiefelError as broken:
            error: StiefelError = broken
        attempts.again(error)


def covariance(session: Any, P0: Any, to: Optional[int], start: int, every: int, timeout: Optional[float], time: Any,
               rates: bool, times: Any) -> Array:
    """Does what `Session.covariance` says."""
    given, scene = numbers("P0", P0), session._known_scene()
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
    moved = session.state_transition(to, start, every, timeout=timeout, time=time)
    if moved.outcome is not Outcome.REACHED:
        raise FailedPrecondition(f"the step cannot be reached: {moved.run_status.message}")
    Phi, size = moved.matrix, moved.matrix.shape[-1]
    if given.shape != (size, size):
        raise refused("P0", f"the shape {given.shape}: must be ({size}, {size})")
    if rates:
        if size != 6 or scene.system not in ("rigid_body", "right_rigid_body", "moser_veselov"):
            raise refused("rates", f"True: must be False, because {scene.system} has no attitude and momentum of a body in 3D")
        momentum = np.eye(6)
        momentum[3:, 3:] = principal(session.scene, None).momentum(np.eye(3))
        Phi = np.linalg.solve(momentum, Phi @ momentum)
    return np.asarray((Phi @ given @ np.swapaxes(Phi, -1, -2))[which])


def _read(handle: Recreation, request: pb.LinearizeRequest, step: float, timeout: Optional[float]) -> StateTransition:
    steps: list[int] = []
    results: list[dict[str, Array]] = []
    assembly = Assembly()
    price: Optional[Price] = None
    status: Optional[RunStatus] = None
    computed, last = 0, int(getattr(request, "from"))
    with closing(handle.messages("Linearize", request, timeout)) as arriving:
        for message in arriving:
            require(bool(message.fields) or message.HasField("run_status"), "a message is empty")
            computed, last = message.computed_steps, message.step
            if price is None:
                price = replies.price(complete(message, "price").price)
            assembly.take(message.fields)
            if not message.result_continues and assembly.begun:
                steps.append(message.step)
                results.append(assembly.finish())
            if message.HasField("run_status"):
                status = replies.run_status(message.run_status)
                ends_at(message.run_status, last, request.to)
                break
    require(status is not None and not assembly.begun, "it has no end")
    assert status is not None and price is not None
    return _joined(request, step, steps, results, status, computed, price)


def _joined(request: pb.LinearizeRequest, step: float, steps: list[int], results: list[dict[str, Array]],
            status: RunStatus, computed: int, price: Price) -> StateTransition:
    name = "vectors" if len(request.vectors.shape) == 3 else "matrix"
    require(status.outcome != Outcome.REACHED or (bool(steps) and steps[-1] == request.to), "its last result is missing")
    require(steps == sorted(set(steps)), "its results are not in order")
    require(all(name in result and result[name].ndim == (3 if name == "vectors" else 2) for result in results),
            f"a result has no {name}")
    require(not request.bases or all("basis" in result and result["basis"].ndim == 3 for result in results)
            and (not results or "start_basis" in results[0]), "a result has no basis")
    for result in results:
        _check_shape(request, result, results[0])

    def stacked(which: str) -> Optional[Array]:
        if not results or which not in results[0]:
            return None
        arrays = [result[which] for result in results]
        return arrays[0] if request.every == 0 and len(arrays) == 1 else np.stack(arrays)

    reached = np.array(steps, np.int64)
    if request.every == 0 and len(results) == 1:
        reached = reached[0]
    return StateTransition(
        step=reached, time=reached * step,
        matrix=stacked("matrix"), vectors=stacked("vectors"), basis=stacked("basis"),
        start_basis=results[0].get("start_basis") if results else None,
        parameters=("inertia",) * request.inertia + ("step",) * request.step,
        run_status=status, computed_steps=computed, price=price)


def _check_shape(request: pb.LinearizeRequest, result: dict[str, Array], first: dict[str, Array]) -> None:
    """Checks that a result has a column for every vector and every parameter, and a row for every coordinate."""
    given = tuple(request.vectors.shape)
    if len(given) == 3:
        vectors, shape = given[0], result["vectors"].shape
        require(shape[1:] == given[1:] and shape[0] >= vectors, f"its vectors have the shape {shape}")
        extra = shape[0] - vectors
    else:
        basis, start = result["basis"], first["start_basis"]
        vectors, shape = given[0] if given else start.shape[0], result["matrix"].shape
        require(shape[0] == basis.shape[0] and shape[1] >= vectors and basis.shape[1:] == start.shape[1:] and start.ndim == 3,
                f"its matrix has the shape {shape}")
        extra = shape[1] - vectors
    require(extra == 0 if not (request.inertia or request.step) else extra == 1 if not request.inertia
            else extra > request.step, f"it has {extra} parameters")
