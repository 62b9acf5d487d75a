"""
The flips of a T-handle
=======================

A handle that spins about its middle axis flips again and again, although nothing acts on it. By Jacobi's solution of Euler's
equations the time between two flips is 2 K(k)/λ, where K = π/(2 M) with the arithmetic-geometric mean M of 1 and k′. Each power
of ten nearer to the axis adds 2 ln 10/s, where s is the rate at which a small tilt grows.
"""
import math

import matplotlib.pyplot as plt
import numpy as np
import stiefel
from stiefel import solids

half, spin, tilts = math.sqrt(0.5), 5.0, [1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
handle = (solids.cylinder(0.3, 0.01, 0.12, attitude=[half, 0, half, 0])  # the bar, along x
          + solids.cylinder(0.1, 0.008, 0.07, at=[0, 0.035, 0], attitude=[half, half, 0, 0]))  # the stem, along y
I1, I2, I3 = map(float, np.diag(handle.inertia_tensor))


def flip_time(tilt: float) -> float:
    """Returns 2 K(k)/λ of the handle with the rates (spin tilt, spin, 0)."""
    x, y = (I1 * spin * tilt) ** 2, (I2 * spin) ** 2
    high = x * (I3 - I1) / I1 + y * (I3 - I2) / I2  # 2 E I3 - L^2
    mean, other = 1.0, math.sqrt(x * (I3 - I1) / (I1 * high))  # 1 and k'
    while abs(mean - other) > 1e-15 * mean:
        mean, other = (mean + other) / 2, math.sqrt(mean * other)
    return math.pi / mean / math.sqrt((I2 - I1) * high / (I1 * I2 * I3))


def scene(tilt: float) -> stiefel.Scene:
    return stiefel.body_scene(inertia_tensor=handle, angular_velocity=[spin * tilt, spin, 0], step=0.01)


predicted, seen = np.array([flip_time(tilt) for tilt in tilts]), []
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for tilt, wait in zip(tilts, predicted):
        with client.create(scene(tilt)) as session:
            flips = session.events(to=math.ceil(4 * wait / 0.01), events={"field": "angular_velocity", "coefficients": [0, 1, 0]})
            seen.append(np.diff(flips.time))
growth = spin * math.sqrt((I2 - I1) * (I3 - I2) / (I1 * I3))
assert all(abs(times / wait - 1).max() < 1e-12 for times, wait in zip(seen, predicted))
assert abs((predicted[-1] - predicted[-2]) / 2 - 2 * math.log(10) / growth) < 2e-6

figure, (rates, waits) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True, width_ratios=[1.5, 1])
run = stiefel.simulate(scene(tilts[2]), time=4 * float(predicted[2]), every=2, fields=["angular_velocity"])
for axis, dashes, name in ((1, "-", "stem"), (0, "--", "bar"), (2, ":", "normal")):
    rates.plot(run.time, run["angular_velocity"][:, axis], dashes, label=name)
for k in range(4):
    rates.axvline((k + 0.5) * predicted[2], color="0.8", linewidth=3, zorder=0)
rates.set(xlabel="s", title=f"rad/s about the axes, tilt {tilts[2]:g}; grey: Jacobi's flips")
rates.legend(loc="lower left", fontsize=8)
waits.semilogx(tilts, [times.mean() for times in seen], "o", label="simulated")
waits.semilogx(tilts, predicted, "-", color="0.5", label="2 K(k)/λ")
waits.set(xlabel="tilt at the start, ω_bar / ω_stem", title="s between two flips")
waits.legend()
plt.show()
