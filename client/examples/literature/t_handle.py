"""The flips of a T-handle.

    t_handle.py [PICTURE]

A handle that spins about its middle axis in weightlessness flips again and again. L. Euler's equations give its rates by
C. G. J. Jacobi's functions dn, sn and cn, and the time between two flips as 2 K(k) / lambda, where K = pi / (2 M) with
the arithmetic-geometric mean M of 1 and k'. The nearer the spin is to the axis, the longer the handle waits: by
2 ln 10 / s for each power of ten, where s is the rate at which a small tilt grows. This program finds the flips of the
simulated motion.
"""
from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import stiefel
from stiefel import solids

SPIN, TILTS = 5.0, [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
FLIPS = 4
HANDLE = (solids.cylinder(0.3, 0.01, 0.12, attitude=[math.sqrt(0.5), 0, math.sqrt(0.5), 0])  # the bar, along x
          + solids.cylinder(0.1, 0.008, 0.07, at=[0, 0.035, 0], attitude=[math.sqrt(0.5), math.sqrt(0.5), 0, 0]))  # along y


def agm(a: float, b: float) -> float:
    while abs(a - b) > 1e-15 * a:
        a, b = (a + b) / 2, math.sqrt(a * b)
    return a


def flip_time(moments: NDArray[Any], omega: NDArray[Any]) -> float:
    """Returns 2 K(k) / lambda of the body with moments I1 < I2 < I3 about its axes, with the rates `omega`."""
    I1, I2, I3 = map(float, moments)
    x, y, z = (moments * omega) ** 2
    low, high = y * (I2 - I1) / I2 + z * (I3 - I1) / I3, x * (I3 - I1) / I1 + y * (I3 - I2) / I2  # L^2 - 2 E I1, 2 E I3 - L^2
    side = z * (I3 - I2) / I3 - x * (I2 - I1) / I1  # L^2 - 2 E I2
    scale = (I3 - I2) * low if side > 0 else (I2 - I1) * high  # lambda^2 I1 I2 I3
    complement = abs(side) * (I3 - I1) / scale  # k'^2
    return math.pi / agm(1.0, math.sqrt(complement)) / math.sqrt(scale / (I1 * I2 * I3))


def scene(tilt: float) -> stiefel.Scene:
    return stiefel.body_scene(inertia_tensor=HANDLE, angular_velocity=[SPIN * tilt, SPIN, 0], step=0.01)


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    moments = np.diag(HANDLE.inertia_tensor)
    predicted = np.array([flip_time(moments, np.array([SPIN * tilt, SPIN, 0])) for tilt in TILTS])
    seen = []
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        for tilt, wait in zip(TILTS, predicted):
            with client.create(scene(tilt)) as session:
                flips = session.events(math.ceil(FLIPS * wait / 0.01), {"field": "angular_velocity", "coefficients": [0, 1, 0]})
                seen.append(flips.time)
    off = max(abs(np.diff(times) / wait - 1).max() for times, wait in zip(seen, predicted))
    growth = SPIN * math.sqrt((moments[1] - moments[0]) * (moments[2] - moments[1]) / (moments[0] * moments[2]))
    per_decade = (predicted[-1] - predicted[-2]) / math.log10(TILTS[-2] / TILTS[-1])

    figure, (rates, waits) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True, width_ratios=[1.5, 1])
    run = stiefel.simulate(scene(TILTS[2]), time=FLIPS * float(predicted[2]), every=2, fields=["angular_velocity"])
    for axis, style in ((1, "-"), (0, "--"), (2, ":")):
        rates.plot(run.time, run["angular_velocity"][:, axis], style, color="black" if axis == 1 else "0.4",
                   label=("bar", "stem", "normal")[axis])
    for k in range(FLIPS):
        rates.axvline((k + 0.5) * predicted[2], color="0.7", linewidth=3, zorder=0)
    rates.set(xlabel="s", title=f"rad/s about the axes, tilt {TILTS[2]:g}; grey: Jacobi's flips")
    rates.legend(loc="lower left", fontsize=8)
    waits.semilogx(TILTS, [np.diff(times).mean() for times in seen], "o", color="black", label="simulated")
    waits.semilogx(TILTS, predicted, "-", color="0.5", label="2 K(k) / λ")
    waits.set(xlabel="tilt at the start, ω_bar / ω_stem", title="s between two flips")
    waits.legend()
    figure.savefig(picture, dpi=80)

    print(f"T-handle: the flips of {len(TILTS)} spins, {predicted[0]:.6f} s to {predicted[-1]:.6f} s apart, follow one another "
          f"after 2 K(k) / lambda within {off:.1e} of it; each power of ten nearer to the axis adds {per_decade:.6f} s, "
          f"2 ln 10 / s is {2 * math.log(10) / growth:.6f} s.")


if __name__ == "__main__":
    main()
