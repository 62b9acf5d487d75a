"""The Riemannian logarithm on the Stiefel manifold.

    stiefel_distances.py [PICTURE]

S. Mataigne, R. Zimmermann and N. Miolane (2025) compute logarithms, and with them distances, on the Stiefel manifold; the
metric of this package with Lambda = I is their Euclidean one, beta = 1. Its injectivity radius is pi (R. Zimmermann and
J. Stoye 2024). This program draws velocities V, and asks for the logarithm of exp(V). Below pi this has to be V. Beyond pi
it fails to be V, at once where V turns one vector of the frame alone: that geodesic is a circle of length 2 pi, and the
way back is shorter.
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

import stiefel.manifold

ROWS, COLUMNS, PAIRS = 2, 5, 10
LENGTHS = np.pi * np.array([0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 1.01, 1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7])
SAME = 1e-9  #: of two velocities
KINDS = ("any V", "V that turns one vector")


def velocities(manifold: stiefel.manifold.Stiefel, Q: NDArray[Any], kind: str) -> NDArray[Any]:
    """Returns unit tangent vectors, one at each frame of Q: any, or one that turns the first vector of the frame alone."""
    if kind == KINDS[0]:
        return manifold.random_tangent(Q, seed=2)
    free = np.random.default_rng(3).normal(size=(len(Q), COLUMNS))
    free -= np.einsum("kij,kil,kl->kj", Q, Q, free)  # orthogonal to the frame
    V = np.zeros_like(Q)
    V[:, 0] = free / np.linalg.norm(free, axis=1, keepdims=True)
    return V


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    manifold = stiefel.manifold.Stiefel(ROWS, COLUMNS)
    Q = manifold.random(PAIRS, seed=1)
    found, distances, error = {}, {}, 0.0
    for kind in KINDS:
        V = LENGTHS[:, None, None, None] * velocities(manifold, Q, kind)
        frames = np.broadcast_to(Q, V.shape)
        joined = manifold.join(frames, manifold.exp(frames, V))
        apart = abs(joined.velocity - V).max(axis=(2, 3))
        found[kind], distances[kind] = (apart < SAME).mean(axis=1), joined.distance
        error = max(error, apart[LENGTHS < np.pi].max())

    figure, (share, length) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    for kind, style in zip(KINDS, ("o-", "s--")):
        share.plot(LENGTHS / np.pi, 100 * found[kind], style, color="black", markerfacecolor="white", label=kind)
        length.plot(LENGTHS / np.pi, distances[kind].mean(axis=1) / np.pi, style, color="black", markerfacecolor="white",
                    label=f"{kind}, mean")
    length.plot([0, 1, 1.7], [0, 1, 0.3], ":", color="0.5", label="the circle: |V|, then 2π − |V|")
    for axes, place in ((share, "center left"), (length, "lower center")):
        axes.axvline(1, color="0.7", linewidth=3, zorder=0)
        axes.set(xlabel="length of V over π")
        axes.legend(fontsize=8, loc=place)
    share.set(title="log exp V = V, per cent of the pairs", ylim=(-4, 104))
    length.set(title="distance of the frames over π")
    figure.savefig(picture, dpi=80)

    beyond = int(np.argmax(LENGTHS > np.pi))
    circle = abs(distances[KINDS[1]] - np.minimum(LENGTHS, 2 * np.pi - LENGTHS)[:, None]).max()
    any_of, one_of = (100 * found[kind][beyond] for kind in KINDS)
    print(f"Distances on V({ROWS}, {COLUMNS}), Lambda = I: log exp V = V within {error:.1e} for all {2 * PAIRS * beyond} "
          f"velocities up to {LENGTHS[beyond - 1] / np.pi:g} pi; at {LENGTHS[beyond] / np.pi:g} pi for {any_of:.0f} % of any and "
          f"{one_of:.0f} % of those that turn one vector, whose distance is min(|V|, 2 pi - |V|) within {circle:.1e}.")


if __name__ == "__main__":
    main()
