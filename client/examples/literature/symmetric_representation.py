"""The equivalence of the rigid body equations (RBn) and their symmetric representation (SRBn).

    symmetric_representation.py [PICTURE]

[RB] Theorem 3.12: where |M| < 2, the map Psi(Q, P) = (Q, Q^T P - P^T Q) takes the motions of (SRBn), Q' = Q Omega and
P' = P Omega, to those of (RBn), Q' = Q Omega and M' = [M, Omega], and its inverse P = Q exp(asinh(M / 2)) takes them back.
This program integrates both systems in four dimensions, each in its own variables, and maps the results in both
directions. It repeats this with momenta next to the edge |M| = 2, where the inverse of Psi loses digits.
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

Array = NDArray[Any]
INERTIA, TIME = [1.0, 1.5, 2.0, 3.0], 20.0
M_0 = np.array([[0, 0.5, -0.3, 0.6], [-0.5, 0, 0.4, 0.2], [0.3, -0.4, 0, 0.8], [-0.6, -0.2, -0.8, 0]])
EDGES = 10.0 ** np.arange(-12, 0)  #: of 1 - |M| / 2
UNIT = 2.0**-53  #: of rounding


def psi(Q: Array, P: Array) -> Array:
    """Returns M of Q and P, all (..., 4, 4)."""
    return np.asarray(Q.swapaxes(-1, -2) @ P - P.swapaxes(-1, -2) @ Q)


def psi_inverse(Q: Array, M: Array) -> Array:
    """Returns P of Q and M, by the eigenvectors of the Hermitian matrix i M."""
    values, vectors = np.linalg.eigh(1j * M)
    sines = np.clip(values / 2, -1, 1)
    exponential = np.sqrt(1 - sines**2) - 1j * sines  # exp(asinh(-i s)) = exp(-i asin(s))
    return np.asarray(Q @ ((vectors * exponential[..., None, :]) @ vectors.conj().swapaxes(-1, -2)).real)


def both(M: Array) -> tuple[stiefel.Trajectory, stiefel.Trajectory]:
    """Returns the motion of (RBn) from Q = I and M, and the motion of (SRBn) from the P that belongs to them."""
    usual = stiefel.simulate({"system": "rigid_body", "inertia": INERTIA, "step": 0.1, "initial": {"Q": np.eye(4), "M": M}},
                             time=TIME, every=1, fields=["Q", "M"])
    symmetric = stiefel.simulate({"system": "symmetric_rigid_body", "inertia": INERTIA, "step": 0.1, "epsilon": 1.0,
                                  "initial": {"Q": np.eye(4), "P": psi_inverse(np.eye(4), M)}},
                                 time=TIME, every=1, fields=["Q", "P"])
    return usual, symmetric


def largest(difference: Array) -> Array:
    return np.asarray(abs(difference).max(axis=(-2, -1)))


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    usual, symmetric = both(M_0)
    apart = {"Q": largest(usual["Q"] - symmetric["Q"]),
             "M, and QᵀP − PᵀQ": largest(usual["M"] - psi(symmetric["Q"], symmetric["P"])),
             "P, and Q exp(asinh(M/2))": largest(symmetric["P"] - psi_inverse(usual["Q"], usual["M"]))}
    lost = []
    for edge in EDGES:
        usual_there, symmetric_there = both(M_0 * (2 * (1 - edge) / np.linalg.norm(M_0, 2)))
        lost.append(largest(symmetric_there["P"] - psi_inverse(usual_there["Q"], usual_there["M"])).max())

    figure, (over_time, at_edge) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    for (name, values), style in zip(apart.items(), ("-", "--", ":")):
        over_time.semilogy(usual.time, values + 1e-17, style, color="black", label=name)
    over_time.set(xlabel="time", title="differences between the two systems")
    over_time.legend()
    at_edge.loglog(EDGES, lost, "o", color="black", label="largest difference of P")
    at_edge.loglog(EDGES, UNIT / np.sqrt(1 - (1 - EDGES) ** 2), "--", color="0.5", label="rounding unit / (1 − (|M|/2)²)^½")
    at_edge.set(xlabel="1 − |M|/2", title="the inverse of Ψ next to |M| = 2")
    at_edge.legend()
    figure.savefig(picture, dpi=80)

    names = [f"{values.max():.1e} in {name}" for name, values in zip("QMP", apart.values())]
    print(f"(RBn) and (SRBn), N = 4: up to t = {TIME:g} they differ by at most {', '.join(names)}; both end with "
          f"Q_11 = {usual['Q'][-1, 0, 0]:.9f} and {symmetric['Q'][-1, 0, 0]:.9f}; "
          f"at 1 - |M|/2 = {EDGES[0]:.0e} P differs by {lost[0]:.1e}.")


if __name__ == "__main__":
    main()
