"""
Order and chaos on V(2, 3)
==========================

Poincaré sections of geodesics of two-frames in space, at one energy and one momentum of the turns of the frame in its plane. A point
is the direction of the plane's normal, where M₁₃ = 0 and rises. Left, two of the three numbers of Λ are equal: a third integral,
M₁₂, keeps every geodesic on curves. Right, they differ: islands lie in a sea, and no third integral exists
(docs/integrability.md).
"""
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import stiefel

SECTION, M12 = {"M": [[0, 0, 1], [0, 0, 0], [0, 0, 0]]}, {"M": [[0, 1, 0], [0, 0, 0], [0, 0, 0]]}


def normal(section: stiefel.Events) -> Any:
    return np.cross(section["Q"][:, 0], section["Q"][:, 1])


figure, both = plt.subplots(1, 2, figsize=(10, 5), sharey=True, constrained_layout=True)
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for axes, inertia in zip(both, ([1, 1, 4], [1, 4, 12])):
        manifold, rng, spread = stiefel.manifold.Stiefel(2, 3, inertia), np.random.default_rng(1), 0.0
        for k in range(9):
            Q = manifold.random(seed=rng)
            V = manifold.velocity(Q, manifold.random_tangent(Q, seed=rng), 0.5, [[0, 0.3], [-0.3, 0]])
            scene: stiefel.Scene = {"system": "stiefel", "inertia": inertia, "step": 0.1, "initial": {"Q": Q, "Qdot": V},
                                    "method": {"name": "variational", "order": 2}}
            with client.create(scene) as session:
                points = session.poincare(SECTION, to=60_000, fields=["Q", "M"], coordinates=[
                    lambda s: np.degrees(np.arctan2(normal(s)[:, 0], normal(s)[:, 2])), lambda s: normal(s)[:, 1], M12]).points
            axes.plot(*points[:, :2].T, ".", markersize=1.5, color=plt.get_cmap("tab10")(k))
            spread = max(spread, np.ptp(points[:, 2]) if len(points) else 0.0)
        axes.set(title=f"Λ = {inertia}: M₁₂ varies by {spread:.1g}", xlabel="azimuth of the normal, °", xlim=(-180, 180))
        assert (spread < 1e-9) == (inertia[0] == inertia[1])
both[0].set(ylabel="its height along the second axis", ylim=(-1, 1))
plt.show()
