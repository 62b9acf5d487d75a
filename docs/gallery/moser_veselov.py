"""
The integrals of Moser and Veselov
==================================

The discrete rigid body UΛ − ΛUᵀ = hM, M′ = UᵀMU of J. Moser and A. P. Veselov (1991) keeps every coefficient of tr(M + μΛ²)ᵏ. In
four dimensions four of them depend on M, which has six numbers and stays on a torus. Left, the momenta of 20 000 large steps in
two of these numbers; right, how the four integrals change in them, and in the same steps of the classical Runge-Kutta method.
"""
import matplotlib.pyplot as plt
import numpy as np
import stiefel

inertia, step, steps = [1.0, 2.0, 3.0, 4.0], 0.8, 20_000
M_0 = np.array([[0, 1.2, -0.5, 0.7], [-1.2, 0, 0.9, 0.4], [0.5, -0.9, 0, 1.6], [-0.7, -0.4, -1.6, 0]])
names = ["tr M²", "tr M⁴", "tr M²Λ²", "2 tr M²Λ⁴ + tr (MΛ²)²"]
scenes: dict[str, stiefel.Scene] = {
    "the map": {"system": "moser_veselov", "inertia": inertia, "step": step, "initial": {"Q": np.eye(4), "M": M_0}},
    "rk4": {"system": "rigid_body", "inertia": inertia, "step": step, "initial": {"M": M_0}, "method": {"name": "rk4"}}}
figure, (torus, drift) = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True)
L, worst = np.diag(np.square(inertia)), {}
for name, scene in scenes.items():
    run = stiefel.simulate(scene, to=steps, every=4, fields=["M"])
    M = run["M"]
    M2 = M @ M
    integrals = np.stack([np.trace(one, axis1=1, axis2=2) for one in (M2, M2 @ M2, M2 @ L, 2 * M2 @ L @ L + M @ L @ M @ L)], axis=1)
    change = np.maximum.accumulate(abs(integrals / integrals[0] - 1)) + 2e-17
    worst[name] = change.max()
    for k, dashes in enumerate(("-", "--", "-.", ":")):
        drift.loglog(run.step[1:], change[1:, k], dashes, color="black" if name == "the map" else "tab:red",
                     label=names[k] if name == "the map" else None)
    if name == "the map":
        torus.plot(M[:, 0, 1], M[:, 2, 3], ",", color="black", alpha=0.6)
assert worst["the map"] < 2e-14 and worst["rk4"] > 1e-4
torus.set(xlabel="M₁₂", ylabel="M₃₄", title="momenta of the map: a torus in the plane")
drift.set(xlabel="steps", title="relative change: the map black, rk4 red", ylim=(1e-17, None))
drift.legend(fontsize=8, loc="center left")
plt.show()
