"""
Work and precision of Hairer and Vilmart
========================================

E. Hairer and G. Vilmart (2006) run the discrete rigid body of Moser and Veselov with modified moments of inertia. It is then of
order 4, 6, 8 or 10, and a step costs the same. The errors of the attitude at t = 1 are those from Jacobi's closed form; the
errors that the program expects in steps of 1/40 were computed by another program with 60 digits.
"""
import warnings

import matplotlib.pyplot as plt
import numpy as np
import stiefel

warnings.simplefilter("ignore", stiefel.SceneWarning)  # I₁ + I₂ < I₃, because the paper's moments are rounded
moments, momentum = np.array([0.345, 0.653, 1.0]), np.array([1.8, 0.4, -0.9])
counts = np.array([5, 10, 14, 20, 28, 40, 80, 160, 320])
expected = {2: 7.8e-3, 4: 7.2e-6, 6: 3.2e-9, 8: 8.6e-13}


def scene(steps: int, method: stiefel.Method) -> stiefel.Scene:
    return {"system": "rigid_body", "step": 1 / steps, "method": method,
            "body": {"moments": moments, "angular_velocity": momentum / moments}}


exact = stiefel.simulate(scene(5, {"name": "exact"}), to=5, fields=["quaternion"])["quaternion"][-1]
figure, axes = plt.subplots(figsize=(7.5, 5), constrained_layout=True)
with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
    for order, style in zip((2, 4, 6, 8, 10), ("o-", "s--", "D-.", "^:", "v-")):
        errors, work = np.empty((2, len(counts)))
        for k, steps in enumerate(counts.tolist()):
            method: stiefel.Method = {"name": "variational" if order == 2 else "preprocessed_variational", "order": order}
            with client.create(scene(steps, method)) as session:
                errors[k] = np.linalg.norm(session.step(to=steps, fields="quaternion")["quaternion"] - exact)
                work[k] = steps * session.step_price.work
        above, last = errors > 1e-14, np.flatnonzero(errors > 2e-12)[-2:]  # those that are not of rounding alone
        seen = np.log(errors[last[0]] / errors[last[1]]) / np.log(counts[last[1]] / counts[last[0]])
        assert abs(seen - order) < 0.3 and abs(errors[5] / expected.get(order, errors[5]) - 1) < 0.02
        axes.loglog(work[above], errors[above], style, markersize=5, markerfacecolor="white", label=f"order {order}: seen {seen:.2f}")
axes.set(xlabel="instructions of all steps to t = 1", ylabel="error of the quaternion at t = 1",
         title="discrete rigid body with modified moments", ylim=(3e-15, 1e5))
axes.legend()
plt.show()
