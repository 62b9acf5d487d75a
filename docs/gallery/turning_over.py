"""A body that turns over.

A body that spins about its middle axis turns over again and again, although nothing acts on it. The spin about the axis
changes its sign; the angular momentum in space stays as it is.
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import stiefel

scene: stiefel.Scene = {"system": "rigid_body", "step": 0.05,
                        "body": {"moments": [1, 2, 3], "angular_velocity": [0.001, 1, 0.001]}}
run = stiefel.simulate(scene, time=120.0, every=1, fields=["angular_velocity", "Q", "M"])
spin = run["angular_velocity"]
momentum = run["Q"] @ run["M"] @ run["Q"].swapaxes(1, 2)
assert abs(momentum - momentum[0]).max() < 1e-12 and (np.diff(np.sign(spin[:, 1])) != 0).sum() >= 4

figure, axes = plt.subplots(figsize=(8, 3.5), constrained_layout=True)
for k, (name, dashes) in enumerate((("smallest", "-"), ("middle", (0, (5, 1.5))), ("largest", (0, (1.2, 1.2))))):
    axes.plot(run.time, spin[:, k], label=f"axis of the {name} moment", linestyle=dashes)
axes.set(xlabel="time, s", ylabel="angular velocity, rad/s", xlim=(0, 120))
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3, fontsize=9, frameon=False)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "turning_over.png", dpi=100)
