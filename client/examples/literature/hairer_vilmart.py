"""Work and precision of the preprocessed discrete Moser-Veselov algorithm.

    hairer_vilmart.py [PICTURE]

E. Hairer and G. Vilmart (2006) run the discrete Moser-Veselov map with modified moments of inertia. The map is then of
order 4, 6, 8 or 10, and a step costs the same. This program measures the error of the attitude at t = 1 against Jacobi's
closed form, and draws it over the instructions of all steps. The moments of the body are rounded, so that the smaller two
are less than the largest in sum; the server's warning about this is not shown.
"""
from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Optional

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import stiefel

MOMENTS = np.array([0.345, 0.653, 1.0])
MOMENTUM = np.array([1.8, 0.4, -0.9])
STEPS = [5, 10, 14, 20, 28, 40, 80, 160, 320]  # of which 40 is the one that is printed
ORDERS = [2, 4, 6, 8, 10]
FLOOR = 1e-14  # errors below it are those of rounding


def scene(steps: int, order: Optional[int]) -> stiefel.Scene:
    made: stiefel.Scene = {"system": "rigid_body", "step": 1 / steps,
                           "body": {"moments": MOMENTS, "angular_velocity": MOMENTUM / MOMENTS}}
    if order is None:
        made["method"] = {"name": "exact"}
    else:
        made["method"] = {"name": "variational" if order == 2 else "preprocessed_variational", "order": order}
    return made


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    warnings.simplefilter("ignore", stiefel.SceneWarning)
    exact = stiefel.simulate(scene(5, None), to=5, fields="quaternion")["quaternion"][-1]
    errors, work = np.empty((len(ORDERS), len(STEPS))), np.empty((len(ORDERS), len(STEPS)))
    with stiefel.Server.start() as server, stiefel.Client(server.address) as client:
        for row, order in enumerate(ORDERS):
            for column, steps in enumerate(STEPS):
                with client.create(scene(steps, order)) as session:
                    found = session.step(to=steps, fields="quaternion")["quaternion"]
                    work[row, column] = steps * session.step_price.work
                errors[row, column] = np.linalg.norm(found - exact)

    figure, axes = plt.subplots(figsize=(7.5, 5), constrained_layout=True)
    seen = []
    for order, error, price, style in zip(ORDERS, errors, work, ("o-", "s--", "D-.", "^:", "v-")):
        above = error > FLOOR
        axes.loglog(price[above], error[above], style, color="black", markersize=5, markerfacecolor="white",
                    label=f"order {order}")
        # The order seen is that between the two smallest errors which rounding leaves alone.
        last = np.flatnonzero(error > 200 * FLOOR)[-2:]
        seen.append(np.log(error[last[0]] / error[last[1]]) / np.log(STEPS[last[1]] / STEPS[last[0]]))
    axes.set(xlabel="instructions of all steps to t = 1", ylabel="error of the quaternion at t = 1",
             title="Discrete Moser–Veselov with modified moments")
    axes.legend()
    figure.savefig(picture, dpi=80)

    at = STEPS.index(40)
    print(f"Hairer-Vilmart: the orders {', '.join(map(str, ORDERS))} are seen as {', '.join(f'{one:.2f}' for one in seen)}; "
          f"at h = 1/40 the errors are {', '.join(f'{one:.1e}' for one in errors[:, at])}, and a step of order 10 takes "
          f"{work[-1, at] / work[1, at]:.2f} times the instructions of one of order 4.")


if __name__ == "__main__":
    main()
