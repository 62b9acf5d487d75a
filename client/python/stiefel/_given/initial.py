"""What an initial state may be given as: velocities instead of the momentum that a system has, Omega of a body in N dimensions and Q' of
a frame; quaternions of any norm, and what was rounded to a few digits: orthonormal frames, tangent velocities, skew momenta."""
from __future__ import annotations

import copy
from typing import Any, Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.attitudes import ROUNDED, of_norm_1
from stiefel._given.numbers import refused
from stiefel._wire.arrays import blocks_of, put_block
from stiefel.errors import InvalidArgument, Violation

VELOCITIES = ("Omega", "Qdot")
MOMENTA = ("M", "P", "S", "B")  #: the blocks of which a velocity takes the place
_FRAMES = ("Q", "Q_prev", "q")
_RULES = ("must have norm 1", "must have orthonormal rows", "must be tangent", "must be skew-symmetric")


def velocity_in(scene: pb.Scene) -> str:
    """Returns the name of the velocity that the scene has instead of a momentum; "" for none."""
    return next((name for name in VELOCITIES if name in scene.initial or name in scene.initial_tensors), "")


def with_momenta(scene: pb.Scene, systems: Callable[[], Any]) -> pb.Scene:
    """Returns the scene, in which M = Lambda Omega + Omega Lambda stands for Omega, where Q' = Q Omega (Q' = Omega Q if the frame
    takes space to body), and S = Q' Lambda, P = S or M = Q^T S - S^T Q for Qdot on V(n, N). `systems`: those of the server."""
    given = velocity_in(scene)
    info = next((system for system in systems() if system.name == scene.system), None) if given else None
    if info is None:
        return scene
    path, is_body, blocks = f"scene.initial.{given}", info.side != pb.SIDE_UNSPECIFIED, blocks_of(scene)
    if info.velocity not in VELOCITIES or given == "Omega" and not is_body:
        takes = "Qdot" if info.velocity == "Qdot" else "neither Omega nor Qdot"
        raise refused(path, f"must be absent: {scene.system} takes {takes}")
    for other in (*VELOCITIES, *MOMENTA):
        if other in blocks and other != given:
            raise refused(path, f"must be absent where {other} is given")
    if not scene.inertia:
        raise refused("scene.inertia", f"absent: must be given where {given} is, one number for each column")
    stacked = {name: blocks[name].reshape(scene.members or 1, -1, blocks[name].shape[-1]) for name in {given, "Q"} & {*blocks}}
    velocity, Q = stacked[given], stacked.get("Q")
    n, N = velocity.shape[-2:]
    if len(scene.inertia) not in (N, len(velocity) * N):
        turned = len(scene.inertia) in (n, len(velocity) * n) and N < n
        raise refused(path, f"the shape {(n, N)}: must have as many columns as inertia has numbers, {len(scene.inertia)}"
                            + "; it looks transposed: frames have their vectors as rows" * turned)
    if given == "Omega" and n != N:
        raise refused(path, f"the shape {(n, N)}: must be {(N, N)}")
    if (given == "Qdot" and is_body or info.momentum == "M" and not is_body) and (Q is None or Q.shape != velocity.shape):
        raise refused(path, f"the shape {(n, N)}: must be that of the matrix Q")
    Lambda = np.reshape(scene.inertia, (-1, 1, N))
    if is_body:
        Omega = velocity if given == "Omega" else velocity @ _T(Q) if info.side == pb.SIDE_RIGHT else _T(Q) @ velocity
        defect = np.max(np.abs(Omega + _T(Omega)), initial=0.0)
        if given == "Omega" and defect > 0.01 * np.max(np.abs(Omega), initial=0.0):
            raise refused(path, f"max |Omega + Omega^T| = {defect:.3g}: must be skew-symmetric")
        momentum = _T(Lambda) * Omega + Omega * Lambda
    else:
        S = velocity * Lambda
        momentum = _T(Q) @ S - _T(S) @ Q if info.momentum == "M" else S
    changed = copy.deepcopy(scene)
    changed.initial.pop(given, None)
    changed.initial_tensors.pop(given, None)
    put_block(changed, info.momentum, momentum if scene.HasField("members") else momentum[0])
    return changed


def with_given_names(error: InvalidArgument, given: pb.Scene) -> InvalidArgument:
    """Returns the error of a scene, which names Omega or Qdot where the scene has it instead of the momentum."""
    name, momenta = velocity_in(given), [f"scene.initial.{momentum}" for momentum in MOMENTA]
    return retold(error, [Violation(f"scene.initial.{name}" if name and one.field in momenta else one.field, one.description)
                          for one in error.violations])


def retold(error: InvalidArgument, violations: Iterable[Violation]) -> InvalidArgument:
    """Returns the error, which now has these violations."""
    told = tuple(violations)
    if told != error.violations:
        error._say("; ".join(f"{one.field}: {one.description}" for one in told))
        error.violations = told
    return error


def _T(matrix: Any) -> NDArray[Any]:
    return np.swapaxes(matrix, -1, -2)


def normalized(given: pb.Scene) -> pb.Scene:
    """Returns a copy of the scene whose initial state fits. Raises InvalidArgument for what is further than ROUNDED
    from that, relative to its size."""
    scene = copy.deepcopy(given)
    if scene.body.attitude and len(scene.body.attitude) % 4 == 0:
        q = np.reshape(scene.body.attitude, (-1, 4))
        scene.body.attitude[:] = of_norm_1("scene.body.attitude", q).ravel().tolist()
    if scene.inertia_u or scene.HasField("parameter"):  # of systems whose Q is no frame
        return scene
    blocks = blocks_of(scene)
    stacked = {name: block.reshape(scene.members or 1, -1, block.shape[-1]) for name, block in blocks.items()}
    fitting = {name: orthonormal(f"scene.initial.{name}", block) for name, block in stacked.items() if name in _FRAMES}
    for name in {"M", "Omega"} & {*stacked}:
        fitting[name] = _skew(f"scene.initial.{name}", stacked[name])
    for name, frame in (("S", fitting.get("Q")), ("Qdot", fitting.get("Q")), ("qdot", fitting.get("q"))):
        if name in stacked and frame is not None and frame.shape == stacked[name].shape:
            scale: Any = np.ones(1) if name != "S" else np.reshape(scene.inertia, (-1, 1, frame.shape[-1]))
            fitting[name] = _tangent(f"scene.initial.{name}", frame, stacked[name] / scale) * scale
    for name, block in fitting.items():
        put_block(scene, name, block.reshape(blocks[name].shape))
    return scene


def with_hint(error: InvalidArgument, changes: Callable[[], bool]) -> InvalidArgument:
    """Returns the error. What it says of a state that `normalize` would make fit says so. `changes` makes what was given fit
    and tells whether that changes it."""
    if not any(rule in violation.description for violation in error.violations for rule in _RULES):
        return error
    try:
        if not changes():
            return error
    except InvalidArgument:
        return error
    return retold(error, [Violation(one.field, one.description + "; normalize=True makes it so" * any(rule in one.description for rule in _RULES))
                          for one in error.violations])


def orthonormal(path: str, given: NDArray[Any]) -> NDArray[Any]:
    """Returns the nearest matrices with orthonormal rows: the polar factors."""
    if given.shape[-2] > given.shape[-1]:
        return given  # no frame: the server says so
    left, _, right = np.linalg.svd(given, full_matrices=False)
    frame: NDArray[Any] = left @ right
    _check(path, abs(frame - given))
    return frame


def _skew(path: str, given: NDArray[Any]) -> NDArray[Any]:
    if given.shape[-2] != given.shape[-1]:
        return given
    skew: NDArray[Any] = (given - _T(given)) / 2
    _check(path, abs(skew - given) / (abs(given).max() or 1.0))
    return skew


def _tangent(path: str, frame: NDArray[Any], velocity: NDArray[Any]) -> NDArray[Any]:
    """Returns the nearest velocities with a skew Q'Q^T."""
    product = velocity @ _T(frame)
    part = (product + _T(product)) / 2 @ frame
    _check(path, abs(part) / (abs(velocity).max() or 1.0))
    return np.asarray(velocity - part)


def _check(path: str, change: NDArray[Any]) -> None:
    if not change.max(initial=0.0) <= ROUNDED:
        raise refused(path, f"changes by {change.max():.3g}: normalize changes a state by at most {ROUNDED}")
