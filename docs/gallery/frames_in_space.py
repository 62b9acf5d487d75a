"""Frames in space.

`plot3d` draws the vectors of frames, here a geodesic on V(2, 3) for the metric of Λ = diag(1, 2, 4): each vector leaves a line on the
unit sphere, and the two stay orthonormal.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import numpy as np
import stiefel

Q = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
Qdot = Q @ np.array([[0.0, 0.5, -0.3], [-0.5, 0.0, 0.8], [0.3, -0.8, 0.0]])
scene: stiefel.Scene = {"system": "stiefel", "inertia": [1, 2, 4], "step": 0.05, "initial": {"Q": Q, "Qdot": Qdot}}
run = stiefel.simulate(scene, time=20.0, every=1)
assert abs(run["Q"] @ run["Q"].swapaxes(1, 2) - np.eye(2)).max() < 1e-12
run.plot3d().savefig(sys.argv[1] if len(sys.argv) > 1 else "frames_in_space.png", dpi=100)
