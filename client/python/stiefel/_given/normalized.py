"""Initial states made to fit: quaternions of any norm, and what was rounded to a few digits: orthonormal frames, tangent
velocities, skew momenta."""
from __future__ import annotations

import copy
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._given.attitudes import ROUNDED, of_norm_1
from stiefel._given.numbers import refused
from stiefel._wire.arrays import blocks_of, put_block
from stiefel.errors import InvalidArgument, Violation

_FRAMES = ("Q", "Q_prev", "q")
_RULES = ("must have norm 1", "must have orthonormal rows", "must be tangent", "must be skew-symmetric")


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
    told = [Violation(one.field, one.description + "; normalize=True makes it so" * any(rule in one.description for rule in _RULES))
            for one in error.violations]
    error._say(f"{told[0].field}: {told[0].description}" if error.message.startswith(told[0].field) else error.message)
    error.violations = tuple(told)
    return error


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
    skew: NDArray[Any] = (given - np.swapaxes(given, -1, -2)) / 2
    _check(path, abs(skew - given) / (abs(given).max() or 1.0))
    return skew


def _tangent(path: str, frame: NDArray[Any], velocity: NDArray[Any]) -> NDArray[Any]:
    """Returns the nearest velocities with a skew Q'Q^T."""
    product = velocity @ np.swapaxes(frame, -1, -2)
    part = (product + np.swapaxes(product, -1, -2)) / 2 @ frame
    _check(path, abs(part) / (abs(velocity).max() or 1.0))
    return np.asarray(velocity - part)


def _check(path: str, change: NDArray[Any]) -> None:
    if not change.max(initial=0.0) <= ROUNDED:
        raise refused(path, f"changes by {change.max():.3g}: normalize changes a state by at most {ROUNDED}")
