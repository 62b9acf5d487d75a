"""How far the shortest turn from one sample to the next is from the motion between them."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._results.attitude import angle_between, between
from stiefel._results.motion import start_of
from stiefel._rotations import of_matrices

Array = NDArray[np.float64]
PARTS = 8  #: of an interval, at whose ends the two are compared
ANGLE = 0.5  #: the largest in radians by which a body turns in one step of the integration
MOST_STEPS = 4096  #: of the integration in one interval
MARGIN = 1.1  #: for what lies between the parts
ROUNDING = 4 * 2**-53  #: of the attitudes, and of the times in the angles of the turns
_LEFT = ("rigid_body", "symmetric_rigid_body", "reduced_rigid_body", "mclachlan_scovel", "stiefel", "stiefel_momentum", "stiefel_costate")


def interpolation_error(time: Array, quaternion: Array, rate: Optional[Array], scene: Optional[Any]) -> float:
    """Returns an upper estimate of the largest angle between the motion and the shortest turns; NaN where nothing is known.

    `scene`: the resolved scene; of a free rigid body the motion between two samples is integrated from the first. Otherwise
    the estimate comes from the distance of each sample from the shortest turn between its neighbours, and from `rate`, the
    angular velocity, which tells of a turn by more than pi.
    """
    if len(time) < 2:
        return float("nan")
    return _of_body(time, quaternion, scene) if scene is not None and _is_body(scene) else _of_samples(time, quaternion, rate)


def rates_of(quaternion: Array, scene: Optional[Any]) -> Optional[Array]:
    """Returns the angular velocities in body axes at the samples of a free rigid body, whose momentum is that of the start;
    None for another scene."""
    if scene is None or not _is_body(scene):
        return None
    I, axes, _, m = _at(quaternion, scene)
    return np.asarray(m / I @ axes.T)


def _is_body(scene: Any) -> bool:
    return scene.get("system") in _LEFT and not scene.get("members")


def _at(quaternion: Array, scene: Any) -> tuple[Array, Array, Array, Array]:
    """Returns the principal moments, their axes, the attitudes of these axes, and the momenta in them."""
    I, axes, attitude, m = start_of(scene)
    L, axes = attitude @ axes @ m, axes * np.linalg.det(axes)
    q = _product(quaternion, of_matrices(axes))
    return I, axes, q, _turned(q * [1, -1, -1, -1], np.broadcast_to(L, (len(q), 3)))


def _of_body(time: Array, quaternion: Array, scene: Any) -> float:
    I, _, q, m = _at(quaternion, scene)
    start, m, h = q[:-1], m[:-1], np.diff(time)
    fastest = float(np.linalg.norm(m[0]) / I.min())
    each = int(min(max(np.ceil(fastest * h.max() / ANGLE / PARTS), 1), MOST_STEPS / PARTS))
    h = (h / (PARTS * each))[:, None]
    worst = 0.0
    for part in range(1, PARTS + 1):
        for _ in range(each):
            middle = _advanced(m, I, h / 2)
            end = _advanced(middle, I, h / 2)
            first, last = m / I, end / I  # the turn by Magnus' series to order 4
            start = _product(start, _turn(h / 6 * (first + 4 * middle / I + last) + h * h / 12 * np.cross(first, last)))
            m = end
        guessed = between(q[:-1], q[1:], np.full(len(start), part / PARTS))
        worst = max(worst, float(angle_between(guessed, start).max()))
    return worst * MARGIN + ROUNDING * (1 + fastest * float(abs(time).max()))


def _advanced(m: Array, I: Array, h: Array) -> Array:
    """Returns the momentum in body axes after a time, by the classical Runge-Kutta method."""
    def slope(m: Array) -> Array:
        return np.asarray(np.cross(m, m / I))
    a = slope(m)
    b = slope(m + h / 2 * a)
    c = slope(m + h / 2 * b)
    return np.asarray(m + h / 6 * (a + 2 * b + 2 * c + slope(m + h * c)))


def _of_samples(time: Array, q: Array, rate: Optional[Array]) -> float:
    if len(time) < 3:
        return float("nan")
    h = np.diff(time)
    if rate is not None:
        fastest = np.linalg.norm(rate, axis=1)
        if (np.maximum(fastest[:-1], fastest[1:]) * h >= np.pi).any():
            return float(np.pi)
    off = angle_between(between(q[:-2], q[2:], h[:-1] / (h[:-1] + h[1:])), q[1:-1])
    acceleration = np.concatenate([[0], 2 * off / (h[:-1] * h[1:]), [0]])
    # a h^2 / 8 within an interval, four times as large because the acceleration of the samples is a mean.
    return float(min((np.maximum(acceleration[:-1], acceleration[1:]) * h * h / 2).max(), np.pi))


def _product(p: Array, q: Array) -> Array:
    a, u, b, v = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    return np.concatenate([a * b - (u * v).sum(-1, keepdims=True), a * v + b * u + np.cross(u, v)], axis=-1)


def _turn(angles: Array) -> Array:
    half = np.linalg.norm(angles, axis=-1, keepdims=True) / 2
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) / 2 * angles], axis=-1)


def _turned(q: Array, x: Array) -> Array:
    return np.asarray(x + 2 * np.cross(q[:, 1:], np.cross(q[:, 1:], x) + q[:, :1] * x))
