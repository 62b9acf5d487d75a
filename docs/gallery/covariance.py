"""How the uncertainty of a tumbling spacecraft grows.

The spin is known to 0.05 %. Lines: the standard deviations of the attitude along the principal axes of its covariance, from
the derivative of the closed form; marks: those of 500 motions drawn from the same distribution. Along the least uncertain axis
the second order, which a covariance leaves out, soon exceeds the first. Right, the drawn attitudes after 30 rotations, with
the ellipse of two standard deviations.
"""
import sys
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

moments, spin, draws, steps = np.array([2.0, 3.0, 4.5]), np.array([0.2, 1.0, 0.15]), 500, 480
step = 30 * 2 * np.pi / np.linalg.norm(spin) / steps
inertia, m = moments.sum() / 2 - moments, moments * spin
P0 = np.diag([2e-4**2] * 3 + [(5e-4 * np.linalg.norm(m))**2] * 3)


def hat(v: Any) -> Any:
    return np.cross(v[..., None, :], np.eye(3)).swapaxes(-1, -2)


def exp_hat(angles: Any) -> Any:
    length, A = np.linalg.norm(angles, axis=-1)[:, None, None], hat(angles)
    return np.eye(3) + np.sinc(length / np.pi) * A + np.sinc(length / 2 / np.pi)**2 / 2 * A @ A


scene: stiefel.Scene = {"system": "rigid_body", "method": {"name": "exact"}, "inertia": inertia, "step": step}
drawn = np.random.default_rng(1).multivariate_normal(np.zeros(6), P0, size=draws)
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    with client.create({**scene, "initial": {"Q": np.eye(3), "M": hat(m)}}) as session:
        P = session.covariance(P0, to=steps, every=1)
        mean = session.trajectory(to=steps, every=1, fields=["Q"])["Q"]
    with client.create({**scene, "members": draws,
                        "initial": {"Q": exp_hat(drawn[:, :3]), "M": hat(m + drawn[:, 3:])}}) as session:
        cloud = session.trajectory(to=steps, every=1, fields=["Q"])["Q"]

turn = np.swapaxes(mean[:, None], -1, -2) @ cloud
eta = np.stack([turn[..., 2, 1] - turn[..., 1, 2], turn[..., 0, 2] - turn[..., 2, 0], turn[..., 1, 0] - turn[..., 0, 1]], -1) / 2
variances, axes_of = np.linalg.eigh(P[:, :3, :3])
seen = np.einsum("kid,kij,kjd->kd", axes_of, np.einsum("kbi,kbj->kij", eta, eta) / draws, axes_of)
assert np.all(np.abs(np.sqrt(seen[1:, 2] / variances[1:, 2]) - 1) < 0.2)
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2), constrained_layout=True)
time = np.arange(steps + 1) * 30 / steps
for k, (colour, dashes, mark) in enumerate([("0.2", ":", "^"), ("#0072B2", "--", "s"), ("#D55E00", "-", "o")]):
    left.plot(time, np.degrees(np.sqrt(variances[:, k])), color=colour, ls=dashes, lw=1.2, label=("least", "second", "most")[k] + " uncertain axis")
    left.plot(time[::24], np.degrees(np.sqrt(seen[::24, k])), mark, color=colour, markersize=4, label=f"of {draws} motions")
left.legend(fontsize=8, ncol=2, loc="upper left", frameon=False)
left.set(yscale="log", ylim=(None, 400), xlabel="rotations", ylabel="standard deviation of the attitude (degrees)")
points, turned = np.degrees(eta[-1] @ axes_of[-1][:, :0:-1]), np.linspace(0, 2 * np.pi, 200)
right.plot(*points.T, ".", markersize=3, color="0.4")
major, minor = 2 * np.degrees(np.sqrt(variances[-1, :0:-1]))
right.plot(major * np.cos(turned), minor * np.sin(turned), color="#D55E00")
right.set(xlabel="along the most uncertain axis (degrees)", ylabel="along the second (degrees)", aspect="equal")
figure.savefig(sys.argv[1], dpi=100)
