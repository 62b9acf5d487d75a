"""The way between two frames.

The shortest way from one frame of two vectors in space to another, in two metrics: with Λ = I, and with Λ = diag(1, 4, 9),
where moving the third coordinate is dear. Each vector draws a line on the sphere; the frames on the way stay orthonormal.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

Q_0 = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
Q_T = np.array([[0.0, 0.6, 0.8], [0.6, -0.64, 0.48]])
figure = plt.figure(figsize=(9, 4.5), constrained_layout=True)
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for k, inertia in enumerate(([1, 1, 1], [1, 4, 9])):
        way = client.geodesic(inertia=inertia, Q_0=Q_0, Q_T=Q_T, samples=200)
        frames = way.trajectory
        assert frames is not None and way.residual < 1e-10 and abs(frames @ frames.swapaxes(1, 2) - np.eye(2)).max() < 1e-12
        axes = figure.add_subplot(1, 2, k + 1, projection="3d")
        u, v = np.mgrid[0:2 * np.pi:40j, 0:np.pi:20j]
        axes.plot_wireframe(np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v), color="lightgray", linewidth=0.3)
        for row, color in enumerate(("tab:blue", "tab:orange")):
            axes.plot(*frames[:, row].T, color=color, linewidth=2)
            for end, style in ((0, "--"), (-1, "-")):
                axes.plot(*zip([0, 0, 0], frames[end, row]), style, color=color, linewidth=1)
        axes.set_box_aspect((1, 1, 1), zoom=1.5)
        axes.set_axis_off()
        axes.plot([], [], "k--", linewidth=1, label="first frame")
        axes.plot([], [], "k-", linewidth=1, label="last frame")
        axes.legend(loc="lower right", fontsize=8, frameon=False)
        axes.set_title(f"Λ = diag{tuple(inertia)}, energy {way.energy:.3f}")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "frames.png", dpi=100)
