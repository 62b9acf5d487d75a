"""The mean of frames.

Forty frames of two orthonormal vectors in space, scattered about one of them. Their Fréchet mean is the frame with the least
sum of squared distances: at each step the logarithms of all frames are averaged and the mean moves along the result. The dots
are the ends of the vectors of the frames; the lines are the vectors of the mean.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from stiefel.manifold import Stiefel

S = Stiefel(2, 3)
random = np.random.default_rng(4)
centre = np.broadcast_to(np.array([[0.6, -0.64, 0.48], [0.8, 0.48, -0.36]]), (40, 2, 3))
frames = S.exp(centre, 0.4 * random.normal(size=(40, 1, 1)) * S.random_tangent(centre, seed=4))
mean, step = frames[0], np.ones((2, 3))
while np.abs(step).max() > 1e-12:
    step = S.log(np.broadcast_to(mean, frames.shape), frames).mean(axis=0)
    mean = S.exp(mean, step)
sums = [(S.dist(np.broadcast_to(Q, frames.shape), frames) ** 2).sum() for Q in (mean, centre[0], frames[0])]
assert sums[0] < min(sums[1:])

figure = plt.figure(figsize=(6, 6), constrained_layout=True)
axes = figure.add_subplot(projection="3d")
u, v = np.mgrid[0:2 * np.pi:40j, 0:np.pi:20j]
axes.plot_wireframe(np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v), color="lightgray", linewidth=0.3)
for row, color in enumerate(("tab:blue", "tab:orange")):
    axes.scatter(*frames[:, row].T, color=color, s=12)
    axes.plot(*zip([0, 0, 0], mean[row]), color=color, linewidth=3)
axes.set_box_aspect((1, 1, 1), zoom=1.6)
axes.view_init(20, -20)
axes.set_axis_off()
axes.set_title("Fréchet mean of 40 frames")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "mean.png", dpi=100)
