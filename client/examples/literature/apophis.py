"""The tumbling asteroid (99942) Apophis.

    apophis.py [PICTURE]

P. Pravec et al. (2014) found two periods in the light of Apophis, precession P_phi = 27.38 h and rotation P_psi = 263 h, in
a short axis mode, and fitted moments in the ratios I_1 / I_3 = 0.61 and I_2 / I_3 = 0.965. This program makes the motion
from these, reads both periods off its attitude, and predicts a number of the paper that did not go in: the energy over
that of a rotation about the short axis with the same momentum, E / E_0 = 1.024 +- 0.013. The long axis precesses in
30.56 h, since 1 / 30.56 = 1 / 27.38 - 1 / 263.
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import stiefel

HOUR = 3600.0
P_PHI, P_PSI, MOMENTS = 27.38 * HOUR, 263 * HOUR, [0.61, 0.965, 1.0]
TURNS = 4  # of psi


def spin(P_phi: float, P_psi: float, moments: list[float]) -> tuple[float, NDArray[Any]]:
    """Returns theta and the angular velocity at psi = 0 of the motion with these periods in short axis mode.

    With g = sin^2(psi) / I_1 + cos^2(psi) / I_2 and D = 2 E / L^2: phi' = L g and |psi'| = L ((g - D) (g - 1 / I_3))^1/2, so that
    P_phi / P_psi depends on D alone. It falls from D = 1 / I_3 to 0 at the separatrix D = 1 / I_2.
    """
    w = 1 / np.array(moments)
    psi = 2 * np.pi * np.arange(4096) / 4096
    g = np.sin(psi) ** 2 * w[0] + np.cos(psi) ** 2 * w[1]

    def turn(D: float) -> tuple[float, float]:
        """The time of a turn of psi where L = 1, and by how much phi advances in it."""
        slow = 2 * np.pi / np.sqrt((g - D) * (g - w[2]))
        return float(slow.mean()), float((g * slow).mean())

    low, high = w[2], w[1]
    for _ in range(60):
        D = (low + high) / 2
        low, high = (D, high) if 2 * np.pi / turn(D)[1] > P_phi / P_psi else (low, D)
    theta = np.arccos(np.sqrt((w[1] - D) / (w[1] - w[2])))
    return float(theta), turn(D)[0] / P_psi * np.array([0.0, np.sin(theta), np.cos(theta)]) * w


def angles(Q: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Returns phi, theta and psi of Q = Rz(phi) Rx(theta) Rz(psi), where space z is the momentum and body z the short axis."""
    phi, psi = np.arctan2(Q[:, 0, 2], -Q[:, 1, 2]), np.arctan2(Q[:, 2, 0], Q[:, 2, 1])
    return np.unwrap(phi), np.arccos(Q[:, 2, 2]), np.unwrap(psi)


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    theta, velocity = spin(P_PHI, P_PSI, MOMENTS)
    scene = stiefel.body_scene(moments=MOMENTS, euler_angles=[0, theta, 0], sequence="ZXZ", angular_velocity=velocity, step=HOUR / 4)
    run = stiefel.simulate(scene, time=TURNS * P_PSI, every=1, fields=["Q"])
    motion = run.motion
    phi, theta, psi = angles(run["Q"])
    # The run lasts whole turns of psi, after which the motion in the body, and the rate of phi, repeat.
    seen_phi, seen_psi = (2 * np.pi * run.time[-1] / abs(one[-1] - one[0]) / HOUR for one in (phi, psi))
    energy = motion.energy / (motion.momentum @ motion.momentum / (2 * MOMENTS[2]))
    long_axis = motion.precession_period / HOUR

    figure, (path, turning) = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True, width_ratios=[1, 1.4])
    for axis, style, hours in ((2, "-", P_PSI / HOUR), (0, ":", 20.0)):
        x, y, _ = run["Q"][run.time <= hours * HOUR, :, axis].T
        path.plot(x, y, style, color="black", label=f"{'long' if axis == 0 else 'short'} axis, {hours:g} h", linewidth=0.9)
    path.add_patch(plt.Circle((0, 0), 1, fill=False, color="0.8"))
    path.set(aspect="equal", title="seen from the momentum", xticks=[], yticks=[], xlim=(-1.05, 1.05), ylim=(-1.05, 1.35))
    path.legend(loc="upper left", fontsize=8, ncol=2, frameon=False)
    turning.plot(run.time / HOUR, phi / (2 * np.pi), "-", color="black", label=f"φ: a turn in {seen_phi:.2f} h")
    turning.plot(run.time / HOUR, psi / (2 * np.pi), "--", color="black", label=f"ψ: a turn in {seen_psi:.1f} h, backwards")
    turning.plot(run.time / HOUR, np.degrees(theta) / 10, ":", color="0.4", label="θ, in tens of degrees")
    turning.set(xlabel="hours", title="turns")
    turning.legend()
    figure.savefig(picture, dpi=80)

    print(f"Apophis: a {motion.kind} with P_phi = {seen_phi:.2f} h and P_psi = {seen_psi:.1f} h as observed; predicted are "
          f"E/E_0 = {energy:.4f}, observed 1.024 +- 0.013, and {long_axis:.2f} h for the long axis, as 1 / (1 / P_phi - 1 / P_psi).")


if __name__ == "__main__":
    main()
