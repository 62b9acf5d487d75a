"""The integrals of the discrete rigid body of Moser and Veselov.

    moser_veselov_integrals.py [PICTURE]

The discrete rigid body U Lambda - Lambda U^T = h M, M' = U^T M U of J. Moser and A. P. Veselov (1991) keeps every
coefficient of tr (M + mu Lambda^2)^k. In four dimensions four of these depend on M. The momentum has six numbers, and
therefore stays on a surface, a torus. This program runs 20000 large steps of the map, and the same steps of the
classical Runge-Kutta method, and evaluates the four integrals from the momenta.
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

import stiefel

INERTIA = [1.0, 2.0, 3.0, 4.0]
STEP, STEPS, EVERY = 0.8, 20_000, 4
M_0 = np.array([[0, 1.2, -0.5, 0.7], [-1.2, 0, 0.9, 0.4], [0.5, -0.9, 0, 1.6], [-0.7, -0.4, -1.6, 0]])
NAMES = ["tr M²", "tr M⁴", "tr M²Λ²", "2 tr M²Λ⁴ + tr (MΛ²)²"]


def integrals(M: NDArray[Any]) -> NDArray[Any]:
    """Returns the coefficients of tr (M + mu Lambda^2)^k that depend on M, up to constant factors, for momenta (..., 4, 4)."""
    L, M2 = np.diag(np.square(INERTIA)), M @ M
    return np.stack([np.trace(one, axis1=-2, axis2=-1) for one in
                     (M2, M2 @ M2, M2 @ L, 2 * M2 @ L @ L + M @ L @ M @ L)], axis=-1)


def run(scene: stiefel.Scene) -> stiefel.Trajectory:
    return stiefel.simulate(scene, to=STEPS, every=EVERY, fields=["M"])


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    discrete = run({"system": "moser_veselov", "inertia": INERTIA, "step": STEP, "initial": {"Q": np.eye(4), "M": M_0}})
    classical = run({"system": "rigid_body", "inertia": INERTIA, "step": STEP, "initial": {"M": M_0},
                     "method": {"name": "rk4"}})
    start = integrals(M_0)
    drifts = [abs(integrals(one["M"]) / start - 1) for one in (discrete, classical)]
    M, turns = discrete["M"], STEP * np.linalg.norm(M_0 / np.add.outer(INERTIA, INERTIA), 2)

    figure, (torus, drift) = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True)
    torus.plot(M[:, 0, 1], M[:, 2, 3], ",", color="black", alpha=0.6)
    torus.set(xlabel="M₁₂", ylabel="M₃₄", title="momenta of the map: a torus in the plane")
    for k, (name, style) in enumerate(zip(NAMES, ("-", "--", "-.", ":"))):
        drift.loglog(discrete.step[1:], np.maximum.accumulate(drifts[0][1:, k]) + 2e-17, style, color="black", label=name)
        drift.loglog(classical.step[1:], np.maximum.accumulate(drifts[1][1:, k]), style, color="0.55")
    drift.set(xlabel="steps", title="relative change: the map black, rk4 grey", ylim=(1e-17, None))
    drift.legend(fontsize=8, loc="center left")
    figure.savefig(picture, dpi=80)

    print(f"Moser-Veselov, N = 4: in {STEPS} steps of h|Omega| = {turns:.2f} the integrals "
          f"{', '.join(f'{value:.6f}' for value in start)} change by at most {drifts[0].max():.1e} of their values, "
          f"with rk4 in the same steps by {drifts[1].max():.1e}.")


if __name__ == "__main__":
    main()
