"""Regular or chaotic.

Geodesics of V(2, 3) with the inertias 1, 4, 12 from random frames. t λ(t) of the regular ones grows like ln t, that of the
chaotic ones in proportion to t; the volume GALI₂ of two vectors stays or falls exponentially.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

inertia = np.array([1.0, 4, 12])
styles = {"regular": ("#004c7a", "-"), "chaotic": ("#E69F00", "-"), "undecided": ("0.5", ":")}
random = np.random.default_rng(1)
figure, (growth, volume) = plt.subplots(1, 2, figsize=(9, 4), constrained_layout=True)
seen = set()
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for k in range(10):
        Q = np.linalg.qr(random.normal(size=(3, 2)))[0].T
        V = random.normal(size=(2, 3))
        V -= (V @ Q.T + Q @ V.T) / 2 @ Q
        V /= np.sqrt(np.sum(V**2 * inertia))
        scene: stiefel.Scene = {"system": "stiefel", "inertia": inertia, "step": 0.2, "initial": {"Q": Q, "S": V * inertia},
                                "method": {"name": "variational", "order": 4}}
        with client.create(scene) as session:
            found = session.lyapunov(to=30_000, count=2, every=20)
        colour, dashes = styles[found.verdict]
        label = None if found.verdict in seen else found.verdict
        seen.add(found.verdict)
        growth.loglog(found.times, found.times * found.history[:, 0], dashes, color=colour, linewidth=1, label=label)
        volume.loglog(found.times, np.maximum(np.exp(found.log_gali_history[:, 0]), 1e-300), dashes, color=colour, linewidth=1)
assert {"regular", "chaotic"} <= seen
t = np.geomspace(10, 6000)
growth.loglog(t, np.log(t), "k--", label="ln t")
growth.set(xlabel="t", ylabel="t λ(t)", xlim=(10, None), ylim=(0.3, None), title="largest growth")
volume.set(xlabel="t", ylabel="GALI₂", xlim=(10, None), ylim=(1e-16, 2), title="volume of two vectors")
growth.legend()
figure.savefig(sys.argv[1], dpi=100)
