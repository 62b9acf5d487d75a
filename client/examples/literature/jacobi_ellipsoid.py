"""Jacobi's geodesics on the ellipsoid.

    jacobi_ellipsoid.py [PICTURE]

[ST] section 2.3: geodesics on the ellipsoid x^2/a + y^2/b + z^2/c = 1 are integrable. C. G. J. Jacobi solved them in the
ellipsoidal coordinates u < v of a point, the roots of x^2/(a-w) + y^2/(b-w) + z^2/(c-w) = 1 other than 0:

    integral of sqrt(u / ((u-a)(b-u)(c-u)(rho-u))) du - integral of sqrt(v / ((v-a)(v-b)(c-v)(v-rho))) dv = constant,

both along the path. The geodesic touches the lines of curvature u = rho, and Joachimsthal's integral is 2 E rho / (a b c).
This program follows a geodesic, reads u and v off its points, and evaluates both integrals of Jacobi. Next to these
lines the rounding of rho - u limits the comparison to about 1e-8.
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Callable

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import stiefel

Array = NDArray[Any]
a, b, c = SQUARES = np.array([1.0, 4.0, 9.0])
START, VELOCITY = np.array([0.1, 0.2, 1.0]), np.array([0.9, 0.45, 0.0])
TIME = 400.0  # at unit speed
ROWS = np.arange(1, 24)
NODES, VECTORS = np.linalg.eigh(np.diag(ROWS / np.sqrt(4.0 * ROWS**2 - 1), 1), "U")  # of Gauss and Legendre


def ellipsoidal(x: Array, velocity: Array) -> tuple[Array, Array, Array]:
    """Returns u, v and the rate of u. u + v = a + b + c - |x|^2 and u v = a b c sum of x_i^2 / a_i^2."""
    total, product = SQUARES.sum() - (x**2).sum(axis=1), SQUARES.prod() * (x**2 / SQUARES**2).sum(axis=1)
    v = total / 2 + np.sqrt(total**2 / 4 - product)
    u = product / v
    rates = -2 * (x * velocity).sum(axis=1), 2 * SQUARES.prod() * (x * velocity / SQUARES**2).sum(axis=1)
    return u, v, (rates[1] - u * rates[0]) / (v - u)


def integral(angle: Array, low: float, high: float, rest: Callable[[Array], Array]) -> Array:
    """Returns the integral of sqrt(w / ((w - low)(high - w) rest(w))) dw over w = low + (high - low) sin^2(angle), from 0."""
    def up_to(end: Array) -> Array:
        w = low + (high - low) * np.sin(np.multiply.outer(end, (NODES + 1) / 2)) ** 2
        return np.asarray(end * (np.sqrt(w / rest(w)) @ (2 * VECTORS[0] ** 2)))  # dw = 2 (w - low)^(1/2) (high - w)^(1/2) d(angle)

    turns = np.round(angle / np.pi)
    return np.asarray(2 * turns * up_to(np.array(np.pi / 2)) + up_to(angle - turns * np.pi))


def main() -> None:
    picture = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).with_suffix(".png")
    q = START / np.linalg.norm(START)
    tangent = VELOCITY - (VELOCITY @ q) * q
    scene: stiefel.Scene = {"system": "ellipsoid", "inertia": SQUARES, "step": 0.05,
                            "initial": {"q": [q], "qdot": [tangent / np.sqrt(tangent**2 @ SQUARES)]}}
    run = stiefel.simulate(scene, time=TIME, every=1, fields=["q", "qdot"])
    joachimsthal = (run["q"] ** 2 @ (1 / SQUARES)) * (run["qdot"] ** 2).sum(axis=1)
    rho = joachimsthal[0] * SQUARES.prod()  # 2 E = 1
    x, velocity = run["q"] * np.sqrt(SQUARES), run["qdot"] * np.sqrt(SQUARES)
    u, v, rate = ellipsoidal(x, velocity)

    # x vanishes where u = a, y where v = b, z where v = c: both angles run on and on.
    phi = np.unwrap(np.arctan2(np.sign(x[:, 0]) * np.sqrt(np.clip(u - a, 0, None)),
                               np.sign(rate * x[:, 0]) * np.sqrt(np.clip(rho - u, 0, None))))
    chi = np.unwrap(np.arctan2(np.sign(x[:, 1]) * np.sqrt(np.clip(v - b, 0, None)),
                               np.sign(x[:, 2]) * np.sqrt(np.clip(c - v, 0, None))))
    first = integral(phi, a, rho, lambda w: (b - w) * (c - w))
    second = integral(np.sign(chi[-1] - chi[0]) * chi, b, c, lambda w: (w - a) * (w - rho))
    apart = first - second

    figure = plt.figure(figsize=(10, 4.4), constrained_layout=True)
    grid = figure.add_gridspec(2, 2)
    space = figure.add_subplot(grid[:, 0], projection="3d")
    space.plot(*x[:2500].T, color="0.45", linewidth=0.5)
    other = np.linspace(b, c, 200)  # the points with u = rho
    squared = [(one * (one - rho) * (one - other)) / np.prod(one - SQUARES[SQUARES != one]) for one in SQUARES]
    for sign in np.ndindex(2, 2, 2):
        space.plot(*[(1 - 2 * s) * np.sqrt(np.clip(one, 0, None)) for s, one in zip(sign, squared)], color="black", linewidth=2)
    space.set_box_aspect(np.sqrt(SQUARES), zoom=1.25)
    space.set_axis_off()
    space.view_init(15, 30)
    space.set_title(f"the geodesic touches the two curves u = {rho:.4f}")
    upper, lower = figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])
    upper.plot(run.time, first, "-", color="black", label="integral in u")
    upper.plot(run.time, second, "--", color="0.5", label="integral in v")
    upper.legend()
    lower.semilogy(run.time[1:], abs(apart - apart[0])[1:] + 1e-17, ".", color="black", markersize=1)
    lower.set(xlabel="length of the path", ylabel="change of the difference")
    figure.savefig(picture, dpi=80)

    print(f"Jacobi, ellipsoid: Joachimsthal's integral predicts that the geodesic turns back at u = {rho:.8f}, it does so at "
          f"{u.max():.8f}; over a length of {TIME:g} Jacobi's integrals grow to {first[-1]:.3f} and stay equal within "
          f"{abs(apart - apart[0]).max():.1e}.")


if __name__ == "__main__":
    main()
