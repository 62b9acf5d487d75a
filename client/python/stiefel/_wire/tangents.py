"""What is read from Linearize and LyapunovSpectrum: results at steps, whatever streams send them."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from stiefel import v1 as pb
from stiefel._given.numbers import numbers, refused, step_index
from stiefel._given.when import absent_with_times, steps_of
from stiefel._results.base import Array
from stiefel._results.body import principal
from stiefel._wire.answers import Layout, name_of
from stiefel._wire.arrays import decode_fields, require, set_tensor
from stiefel._wire.calls import Calls
from stiefel._wire.streams import Results
from stiefel.errors import FailedPrecondition
from stiefel.results import LyapunovSpectrum, StateTransition, Verdict


def linearized(handle: Calls, request: pb.LinearizeRequest, vectors: Any, step: float,
               timeout: Optional[float]) -> StateTransition:
    """Returns the results of the call. `vectors`: (d) or (m, d) by coordinates, (m, rows, cols) as blocks; None for all. `step`: the
    scene's time between two states. A stream that breaks begins anew, because the vectors at a step depend on the request alone."""
    if vectors is not None:
        given = numbers("vectors", vectors)
        if given.ndim not in (1, 2, 3) or not given.size:
            raise refused("vectors", f"the shape {given.shape}: must be (m, d) or (m, rows, cols)")
        set_tensor(request.vectors, given if given.ndim > 1 else given[np.newaxis])
    reading = Results(handle, request, timeout, "fields", endless=False)
    messages, layout = reading.run(), Layout()
    results = [layout.read(field for field in one.fields if field.name != "start_basis") for one in messages]
    start = [field for field in messages[0].fields if field.name == "start_basis"] if messages else []
    require(all(("vectors" if len(request.vectors.shape) == 3 else "matrix") in one for one in results), "a result has no vectors")
    alone = request.every == 0 and len(results) == 1
    steps: Any = np.array([one.step for one in messages], np.int64)
    steps = steps[0] if alone else steps
    found = {name: results[0][name] if alone else np.stack([one[name] for one in results]) for name in (results or [{}])[0]}
    return StateTransition(
        step=steps, time=steps * step, matrix=found.get("matrix"), vectors=found.get("vectors"), basis=found.get("basis"),
        start_basis=decode_fields(start).get("start_basis"), parameters=("inertia",) * request.inertia + ("step",) * request.step,
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
    if not moved.success:
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


def grown(handle: Calls, request: pb.LyapunovSpectrumRequest, timeout: Optional[float]) -> LyapunovSpectrum:
    """Returns the result of the call."""
    reading = Results(handle, request, timeout, "exponents")
    kept, last = reading.run(), reading.last
    count = len(kept[0].exponents) if kept else 0
    require(request.count in (0, count) or not kept, f"it has {count} exponents")
    require(all(len(one.exponents) == count and len(one.log_gali) == count - 1 for one in kept), "its results have other numbers")
    rows, volumes = (np.reshape([np.array(getattr(one, name)) for one in kept], (len(kept), numbers))
                     for name, numbers in (("exponents", count), ("log_gali", max(count - 1, 0))))
    return LyapunovSpectrum(
        exponents=rows[-1:].flatten(), errors=np.array(last.errors),
        verdict=Verdict(name_of(pb.Verdict, last.verdict).lower()), reason=last.reason,
        log_gali=volumes[-1:].flatten(), step=last.step, time=last.time,
        steps=np.array([one.step for one in kept], np.int64), times=np.array([one.time for one in kept]), history=rows,
        log_gali_history=volumes, interval=last.interval, run_status=reading.run_status, checkpoint=reading.checkpoint,
        computed_steps=reading.computed_steps, work=reading.work)
