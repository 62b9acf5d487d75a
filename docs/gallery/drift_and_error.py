"""
Drift and error are two things
==============================

A satellite in steps of 5 s, for six hours. `variational` of order 2 keeps the energy to rounding and loses the attitude;
`rk4` loses both slowly. The error is the distance from the closed form, which is the recommended method.
"""
import matplotlib.pyplot as plt
import numpy as np
import stiefel

scene: stiefel.Scene = stiefel.examples["envisat"]
scene["step"] = 5.0
steps = 4320
methods: list[stiefel.MethodName] = ["variational", "rk4"]
exact = stiefel.simulate(scene, to=steps, every=20, fields=["Q"])
figure, axes = plt.subplots(1, 2, figsize=(9, 3.5), sharey=True, constrained_layout=True)
worst = {}
for name in methods:
    dashes = "-" if name == "variational" else "--"
    run = stiefel.simulate({**scene, "method": {"name": name}}, to=steps, every=20, fields=["Q", "M", "Omega"])
    energy = (run["M"] * run["Omega"]).sum(axis=(1, 2)) / 4
    drift, error = abs(energy / energy[0] - 1), abs(run["Q"] - exact["Q"]).max(axis=(1, 2))
    axes[0].semilogy(run.time / 3600, np.maximum(drift, 1e-17), dashes, label=name)
    axes[1].semilogy(run.time / 3600, np.maximum(error, 1e-17), dashes, label=name)
    worst[name] = drift.max(), error.max()
axes[0].set(title="drift of the energy, relative", xlabel="hours", ylim=(1e-17, 10))
axes[1].set(title="error of the attitude, max |Q − Q(exact)|", xlabel="hours")
axes[1].legend()
assert worst["variational"][0] < 1e-14 and worst["variational"][1] > 0.01 > worst["rk4"][1] > worst["rk4"][0] > 1e-10
plt.show()
