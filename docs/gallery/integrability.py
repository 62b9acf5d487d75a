"""Where chaos begins.

Largest Lyapunov exponents of geodesics from random frames, over how far the numbers of Λ are apart: 1 to the ratio in equal
factors. V(1, 4) is an ellipsoid, whose geodesic flow is integrable. On V(2, 3) and V(2, 4) no flow with three different numbers
is (docs/integrability.md), but the chaos takes so little room at small ratios that random motions show it only at larger ones.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

styles = {"regular": ("#004c7a", "o"), "chaotic": ("#E69F00", "^"), "undecided": ("0.5", "s")}
figure, panels = plt.subplots(1, 3, figsize=(11, 4), sharey=True, constrained_layout=True)
verdicts = []
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for axes, (n, N) in zip(panels, ((1, 4), (2, 3), (2, 4))):
        for k, ratio in enumerate(np.geomspace(1.2, 100, 20)):
            inertia = np.geomspace(1, ratio, N)
            manifold = stiefel.manifold.Stiefel(n, N, inertia)
            rng = np.random.default_rng(k)
            Q = manifold.random(seed=rng)
            scene: stiefel.Scene = {"system": "stiefel", "inertia": inertia, "step": 0.05, "method": {"name": "variational", "order": 2},
                                    "initial": {"Q": Q, "Qdot": manifold.random_tangent(Q, seed=rng)}}
            with client.create(scene) as session:
                found = session.lyapunov(to=60_000, count=2)
            verdicts.append((n, N, found.verdict))
            colour, mark = styles[found.verdict]
            axes.errorbar(ratio, found.exponents[0], found.errors[0], fmt=mark, color=colour, markersize=4, linewidth=0.8)
        axes.set(title=f"V({n}, {N})", xlabel="largest number of Λ : smallest", xscale="log")
assert not any(verdict == "chaotic" for n, N, verdict in verdicts if n == 1)
assert {(2, 3, "chaotic"), (2, 4, "chaotic")} <= set(verdicts)
for verdict, (colour, mark) in styles.items():
    panels[0].plot([], [], mark, color=colour, label=verdict)
panels[0].legend()
panels[0].set(ylabel="largest exponent, per unit of time")
figure.savefig(sys.argv[1], dpi=100)
