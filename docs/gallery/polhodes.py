"""Polhodes.

The angular momentum of a free body, seen from the body, runs on a sphere along curves of constant energy. Around the axes of
the smallest and the largest moment the curves are closed; the two that cross at the middle axis separate both kinds. Here
are 24 motions with moments 1, 2 and 3 kg m² and one size of the momentum, as one ensemble.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

moments = np.array([1.0, 2.0, 3.0])
angles = np.linspace(-np.pi, np.pi, 24, endpoint=False) + 0.05
starts = np.stack([np.cos(angles), 0 * angles, np.sin(angles)], axis=1)  # momenta in the plane of the first and third axis
scene: stiefel.Scene = {"system": "rigid_body", "step": 0.1, "members": len(starts),
                        "body": {"moments": moments, "angular_velocity": starts / moments}}
run = stiefel.simulate(scene, time=60.0, every=1, fields=["angular_velocity"])
momentum = run["angular_velocity"] * moments  # (samples, members, 3)
assert abs(np.linalg.norm(momentum, axis=2) - 1).max() < 1e-12

elevation, azimuth = np.radians([20, 40])
eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
behind = (momentum @ eye < 0)[..., None]

figure = plt.figure(figsize=(6, 6), constrained_layout=True)
axes = figure.add_subplot(projection="3d")
for member in range(len(starts)):
    energy = (starts[member] ** 2 / moments).sum()
    colour = plt.cm.viridis(1.3 * (energy - 1 / 3))  # 1/3 to 1; the end of the scale is too pale on white
    for hidden, alpha in ((~behind, 0.2), (behind, 1.0)):
        axes.plot(*np.where(hidden, np.nan, momentum)[:, member].T, color=colour, linewidth=1.2, alpha=alpha)
ticks = [-1, 0, 1]
axes.set(xlabel="m₁", ylabel="m₂", zlabel="m₃", xticks=ticks, yticks=ticks, zticks=ticks,
         title="Momentum in body axes, kg m²/s; the lighter, the more energy")
axes.set_box_aspect((1, 1, 1), zoom=0.9)
axes.view_init(20, 40)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "polhodes.png", dpi=100)
