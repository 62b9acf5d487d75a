"""The motion of a free rigid body in three dimensions by its closed form: kind, periods, momentum and energy."""
from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stiefel import v1 as pb
from stiefel._results.base import ByValue

KINDS = {pb.MOTION_KIND_AT_REST: "at rest", pb.MOTION_KIND_STEADY: "steady rotation", pb.MOTION_KIND_SHORT_AXIS: "short-axis mode",
          pb.MOTION_KIND_LONG_AXIS: "long-axis mode", pb.MOTION_KIND_SEPARATRIX: "separatrix"}


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ByValue):
    """The exact motion of a free rigid body in three dimensions from the state at step 0, from Jacobi's closed form.

    `kind`: "short-axis mode" (the momentum circles about the axis of the largest moment in the body), "long-axis mode"
    (about that of the smallest), "separatrix", "steady rotation" about an axis, or "at rest". For a body with two equal moments
    the long axis is that of the smallest moment, any in the plane if this is twofold.
    """

    kind: str
    #: 1 - k^2 of the elliptic functions: 0 on the separatrix, where the rounding of a state grows by its inverse.
    separatrix: float
    #: The period of the angular velocity in body axes, P_psi of observers: infinite on the separatrix, in a steady rotation
    #: and at rest.
    period: float
    #: 2 pi over the mean rate at which the long axis turns about the momentum: P_phi of observers in long-axis mode; in
    #: short-axis mode, where their P_phi is that of the short axis, 1 / (1 / P_phi - 1 / P_psi).
    precession_period: float
    nutation: tuple[float, float]  #: the least and the largest angle between momentum and the axis of the mode, in radians
    momentum: NDArray[np.float64]  #: the vector L in space axes; of a scene without Q in body axes at step 0
    energy: float
    moments: NDArray[np.float64]  #: the principal moments in ascending order
    axes: NDArray[np.float64]  #: the principal axes in the body axes of the scene, right-handed, the columns of a matrix
    in_si: bool = field(default=False, repr=False)  #: whether times are in s, momenta in kg m^2/s and energies in J, as those of a scene with `body` are

    @property
    def nutation_period(self) -> float:
        """The period of the angle between the momentum and the axis of the mode: period / 2."""
        return self.period / 2

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
        long = f"{self.precession_period:.10g}{time}"
        short = f"{self.P_phi:.10g}{time} of the short axis, {long} of the long one"
        return (f"<stiefel.Motion: {self.kind}, 1 - k^2 = {self.separatrix:.3g}\n  periods: angular velocity {self.period:.10g}{time}, "
                f"nutation {self.nutation_period:.10g}{time}, precession {short if self.kind == 'short-axis mode' else long}\n"
                f"  L = {self.momentum}{momentum}, E = {self.energy:.10g}{energy}>")


def motion_of(message: pb.BodyMotion, in_si: bool) -> Motion:
    """Reads the server's message. `in_si`: whether the scene has `body`."""
    period, precession = (getattr(message, name) if message.HasField(name) else math.inf for name in ("period", "precession_period"))
    return Motion(KINDS[message.kind], message.separatrix, period, precession, (message.least_nutation, message.largest_nutation),
                  np.array(message.momentum), message.energy, np.array(message.moments), np.reshape(message.axes, (3, 3)), in_si)
