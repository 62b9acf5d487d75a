"""Geodesics on an ellipsoid.

Two geodesics on the ellipsoid with semi-axes 1, 2 and 3. One winds around the long axis between two curves, and crosses
the planes of symmetry forever; the other winds around the short axis. Joachimsthal's integral tells the two kinds apart.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

squares = np.array([1.0, 4.0, 9.0])
semi_axes, elevation, azimuth = np.sqrt(squares), np.radians(15), np.radians(25)
eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
latitude, longitude = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 13), np.linspace(0, 2 * np.pi, 25))
grid = semi_axes[:, None, None] * [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]
figure = plt.figure(figsize=(9, 5), constrained_layout=True)
for k, velocity in enumerate(np.array([[0.0, 0.9, 0.25], [0.0, 0.25, 0.9]])):
    scene: stiefel.Scene = {"system": "ellipsoid", "inertia": squares, "step": 0.02,
                            "initial": {"q": [[1, 0, 0]], "qdot": [velocity / np.linalg.norm(velocity)]}}
    run = stiefel.simulate(scene, time=100.0, every=1, fields=["q", "qdot"])
    q, v = run["q"], run["qdot"]
    kept = (q**2 @ (1 / squares)) * (v**2).sum(axis=1)
    assert np.ptp(kept) < 1e-9 * kept[0]
    axes = figure.add_subplot(1, 2, k + 1, projection="3d")
    axes.plot_wireframe(*grid, color="0.85", linewidth=0.4)
    behind = (q / semi_axes @ eye < 0)[:, None]
    for hidden, alpha in ((~behind, 0.25), (behind, 1.0)):
        axes.plot(*np.where(hidden, np.nan, q * semi_axes).T, linewidth=0.8, color=("tab:blue", "tab:orange")[k], alpha=alpha)
    axes.set(xlim=(-1, 1), ylim=(-2, 2), zlim=(-3, 3))
    axes.set_box_aspect(semi_axes, zoom=1.15)
    axes.set_axis_off()
    axes.set_title(f"Joachimsthal's integral at unit speed: {kept[0] / (v[0] ** 2 @ squares):.3f}", fontsize=10)
    axes.view_init(*np.degrees([elevation, azimuth]))
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "ellipsoid.png", dpi=100)
