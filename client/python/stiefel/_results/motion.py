"""The motion of a free rigid body in three dimensions by its closed form: kind, periods, momentum and energy."""
from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from stiefel._results.base import ByValue

STEADY = 1e-28  #: of the squares of momenta: below it the body turns about one axis


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ByValue):
    """The motion of a free rigid body in three dimensions, from Jacobi's closed form.

    `kind`: "short-axis mode" (the momentum circles about the axis of the largest moment in the body), "long-axis mode"
    (about that of the smallest), "separatrix", or "steady rotation" about an axis. For a body with two equal moments the
    long axis is that of the smallest moment, any in the plane if this is twofold.
    """

    kind: str
    #: 1 - k^2 of the elliptic functions: 0 on the separatrix, where the rounding of a state grows by its inverse.
    separatrix: float
    #: The period of the angular velocity in body axes, P_psi of observers: infinite on the separatrix and in a steady
    #: rotation of a body whose motion nearby has no period.
    period: float
    nutation_period: float  #: the period of the angle between the momentum and the axis of the mode: period / 2
    #: 2 pi over the mean rate at which the long axis turns about the momentum: P_phi of observers in long-axis mode; in
    #: short-axis mode, where their P_phi is that of the short axis, 1 / (1 / P_phi - 1 / P_psi).
    precession_period: float
    nutation: tuple[float, float]  #: the least and the largest angle between momentum and the axis of the mode, in radians
    momentum: NDArray[np.float64]  #: the vector L in space axes
    energy: float
    moments: NDArray[np.float64]  #: the principal moments in ascending order
    in_si: bool = field(default=False, repr=False)  #: whether times are in s, momenta in kg m^2/s and energies in J, as those of a scene with `body` are

    @property
    def P_psi(self) -> float:
        """The period of the rotation about the axis of the mode that observers of light curves report: `period`."""
        return self.period

    @property
    def P_phi(self) -> float:
        """The mean period of the precession of the axis of the mode about the momentum, as observers of light curves report it."""
        rate = 1 / self.precession_period + (1 / self.period if self.kind == "short-axis mode" else 0.0)
        return 1 / rate if rate else math.inf

    def __repr__(self) -> str:
        time, momentum, energy = (" s", " kg m^2/s", " J") if self.in_si else ("", "", "")
        return (f"<stiefel.Motion: {self.kind}, 1 - k^2 = {self.separatrix:.3g}\n"
                f"  periods: angular velocity {self.period:.10g}{time}, nutation {self.nutation_period:.10g}{time}, precession "
                f"{self._precession(time)}\n  L = {self.momentum}{momentum}, E = {self.energy:.10g}{energy}>")

    def _precession(self, time: str) -> str:
        long = f"{self.precession_period:.10g}{time}"
        return long if self.kind != "short-axis mode" else f"{self.P_phi:.10g}{time} of the short axis, {long} of the long one"


def motion_of(scene: Mapping[str, Any]) -> Motion:
    """Returns the motion of a resolved scene of a rigid body in three dimensions, in whatever variables. Raises ValueError for
    another scene."""
    I, axes, attitude, m = start_of(scene)
    order = np.argsort(I, kind="stable")
    return replace(closed_form(I[order], m[order], attitude @ axes @ m), in_si=bool(scene.get("body")))


def closed_form(I: NDArray[Any], m: NDArray[Any], L: NDArray[Any]) -> Motion:
    """`I`: the principal moments in ascending order. `m`: the momentum in these axes. `L`: the momentum in space axes."""
    length = math.hypot(*m)
    energy = float((m * m / I).sum() / 2)
    I1, I2, I3 = map(float, I)
    if length == 0:
        return Motion("at rest", 1.0, math.inf, math.inf, math.inf, (0.0, 0.0), L, energy, I)
    x, y, z = (float(one) ** 2 for one in m / length)
    # 2 E I3 - L^2, L^2 - 2 E I1 and L^2 - 2 E I2, all over L^2, as sums without cancellation but in the last.
    above = x * (I3 - I1) / I1 + y * (I3 - I2) / I2
    below = y * (I2 - I1) / I2 + z * (I3 - I1) / I3
    side = z * (I3 - I2) / I3 - x * (I2 - I1) / I1
    steady = _steady(I, x, y, z)
    if steady is not None and (above <= 0 or below <= 0 or side == 0):
        return Motion("steady rotation", 1.0 if side else 0.0, math.inf, math.inf, 2 * math.pi * steady / length,
                      (0.0, 0.0), L, energy, I)
    if side == 0 or above * below == 0:
        return Motion("separatrix", 0.0, math.inf, math.inf, 2 * math.pi * I2 / length, (0.0, math.pi / 2), L, energy, I)
    if side > 0:
        kind, scale = "short-axis mode", (I3 - I2) * below
        n_of, b_over_c = -I1 * above / (I3 * below), I2 * above * (I3 - I1) / ((I3 - I2) * I3 * below)
        largest = math.sqrt(I3 * below / (I3 - I1))
    else:
        kind, scale = "long-axis mode", (I2 - I1) * above
        n_of, b_over_c = -I1 * (I3 - I2) / (I3 * (I2 - I1)), I2 * (I3 - I1) / (I3 * (I2 - I1))
        largest = math.sqrt(I1 * above / (I3 - I1))
    k2 = min((I3 - I1) * abs(side) / scale, 1.0)  # 1 - k^2
    mean, sums = agm(k2, n_of)
    period = 2 * math.pi / mean * math.sqrt(I1 * I2 * I3 / scale) / length
    # The mean of sn^2 / (1 - n sn^2) over a period is sums / (2 (1 - n)).
    rate = length * (1 / I3 + (I3 - I2) / (I2 * I3) * b_over_c * sums / (2 * (1 - n_of)))
    nutation = (math.acos(min(largest, 1.0)), math.acos(min(largest * math.sqrt(k2), 1.0)))
    return Motion(kind, k2, period, period / 2, 2 * math.pi / rate, nutation, L, energy, I)


def agm(complement: float, n: float) -> tuple[float, float]:
    """Returns the arithmetic-geometric mean M of 1 and k', and the sum of Q_j with which the complete elliptic integrals are
    K = pi / (2 M) and Pi(n) = pi / (4 M) (2 + n / (1 - n) sum), for n < 1. `complement`: k'^2 = 1 - k^2. From DLMF 19.8."""
    a, g, p, q = 1.0, math.sqrt(complement), math.sqrt(1 - n), 1.0
    total = q
    for _ in range(60):
        ratio = (p * p - a * g) / (p * p + a * g)
        a, g, p, q = (a + g) / 2, math.sqrt(a * g), (p * p + a * g) / (2 * p), q * ratio / 2
        total += q
        if abs(a - g) <= 2**-53 * a and abs(q) <= 2**-60 * abs(total):
            break
    return a, total


def _steady(I: NDArray[Any], x: float, y: float, z: float) -> "float | None":
    """Returns the moment about the axis if the body turns about one. `x`, `y`, `z`: squares of the momentum's direction."""
    parts = [(moment, share) for moment, share in zip(map(float, I), (x, y, z)) if share > STEADY]
    return parts[0][0] if len({moment for moment, _ in parts}) == 1 else None


def start_of(scene: Mapping[str, Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Returns principal moments, their axes as columns in the caller's body axes, the attitude as a matrix, and the momentum
    in the principal axes."""
    body, system = scene.get("body"), str(scene.get("system"))
    if scene.get("members"):
        raise ValueError("a closed form is known of one body, and the scene is an ensemble: take `member(0).motion` of the "
                         "trajectory, and so on")
    if system not in _MOMENTUM:
        raise ValueError(f"a closed form is known of a free rigid body in three dimensions: the scene is of {system}")
    if body:
        if body.get("inertia_tensor"):
            xx, yy, zz, xy, xz, yz = body["inertia_tensor"]
            I, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        else:
            I, axes = np.array(body["moments"], float), np.eye(3)
        w, x, y, z = np.array(body["attitude"]) / np.linalg.norm(body["attitude"])
        attitude = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        return I, axes, attitude, I * (axes.T @ body["angular_velocity"])
    blocks = {name: np.asarray(block, float) for name, block in scene["initial"].items()}
    shape = next(iter(blocks.values())).shape
    if shape != (3, 3):
        raise ValueError(f"a closed form is known in three dimensions: the blocks of this {system} are {shape}")
    Q = blocks.get("Q", np.eye(3))
    M = blocks["M"] if "M" in blocks else _MOMENTUM[system](Q, blocks) / (scene.get("epsilon") or 1)
    if system.startswith("right_"):  # whose frame takes space to body
        Q, M = Q.T, -M
    lam = np.array(scene["inertia"], float)
    m = np.array([M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]]) / 2
    return lam.sum() - lam, np.eye(3), np.linalg.det(Q) * Q, m


def _of_product(P: NDArray[Any], Q: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(P.T @ Q - Q.T @ P)


#: The systems that are a rigid body for n = N = 3, and M of a scene that gives another block; in the symmetric forms times epsilon.
_MOMENTUM: dict[str, Callable[[NDArray[Any], Mapping[str, NDArray[Any]]], NDArray[Any]]] = {
    "rigid_body": lambda Q, blocks: blocks["M"],
    "right_rigid_body": lambda Q, blocks: blocks["M"],
    "symmetric_rigid_body": lambda Q, blocks: _of_product(Q, blocks["P"]),
    "reduced_rigid_body": lambda Q, blocks: _of_product(Q, blocks["P"]),
    "right_symmetric_rigid_body": lambda Q, blocks: _of_product(blocks["P"].T, Q.T),
    "mclachlan_scovel": lambda Q, blocks: Q.T @ blocks["B"],
    "stiefel": lambda Q, blocks: _of_product(Q, blocks["S"]),
    "stiefel_momentum": lambda Q, blocks: blocks["M"],
    "stiefel_costate": lambda Q, blocks: _of_product(Q, blocks["P"]),
}
