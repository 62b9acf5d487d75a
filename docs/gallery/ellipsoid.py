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
figure = plt.figure(figsize=(9, 5), constrained_layout=True)
for k, velocity in enumerate(np.array([[0.0, 0.9, 0.25], [0.0, 0.25, 0.9]])):
    scene: stiefel.Scene = {"system": "ellipsoid", "inertia": squares, "step": 0.02,
                            "initial": {"q": [[1, 0, 0]], "qdot": [velocity / np.linalg.norm(velocity)]}}
    run = stiefel.simulate(scene, time=100.0, every=1, fields=["q", "qdot"])
    q, v = run["q"], run["qdot"]
    kept = (q**2 @ (1 / squares)) * (v**2).sum(axis=1)
    assert np.ptp(kept) < 1e-9 * kept[0]
    axes = figure.add_subplot(1, 2, k + 1, projection="3d")
    axes.plot(*(q * np.sqrt(squares)).T, linewidth=0.7, color=("tab:blue", "tab:orange")[k])
    axes.set_box_aspect(np.sqrt(squares))
    axes.set_axis_off()
    axes.set_title(f"Joachimsthal's integral {kept[0]:.2f}")
    axes.view_init(15, 25)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "ellipsoid.png", dpi=100)
