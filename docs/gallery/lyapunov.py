"""Regular or chaotic.

Geodesics of V(2, 4) with the inertias 1, 2, 5, 10 from random frames. t λ(t) of the regular ones grows like ln t, that of the
chaotic ones in proportion to t; the volume GALI₂ of two vectors falls by a power of t or exponentially.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

inertia = np.array([1.0, 2, 5, 10])
random = np.random.default_rng(6)
figure, (growth, volume) = plt.subplots(1, 2, figsize=(9, 4), constrained_layout=True)
verdicts = []
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for k in range(8):
        Q = np.linalg.qr(random.normal(size=(4, 2)))[0].T
        V = random.normal(size=(2, 4))
        V -= (V @ Q.T + Q @ V.T) / 2 @ Q
        V /= np.sqrt(np.sum(V**2 * inertia))
        scene = {"system": "stiefel", "inertia": inertia, "step": 0.2, "method": {"name": "variational", "order": 4},
                 "initial": {"Q": Q, "S": V * inertia}}
        with client.create(scene) as session:
            found = session.lyapunov(to=30_000, count=2, every=20)
        verdicts.append(found.verdict)
        colour = {"regular": "tab:blue", "chaotic": "tab:red", "undecided": "tab:gray"}[found.verdict]
        growth.semilogx(found.times, found.times * found.history[:, 0], color=colour, linewidth=1)
        volume.loglog(found.times, np.maximum(np.exp(found.log_gali_history[:, 0]), 1e-300), color=colour, linewidth=1)
assert "chaotic" in verdicts
growth.set(xlabel="t", ylabel="t λ(t)", xlim=(10, None), title="largest growth")
volume.set(xlabel="t", ylabel="GALI₂", xlim=(10, None), ylim=(1e-16, 2), title="volume of two vectors")
for verdict, colour in (("regular", "tab:blue"), ("chaotic", "tab:red")):
    growth.plot([], [], color=colour, label=verdict)
growth.legend()
figure.savefig(sys.argv[1], dpi=100)
