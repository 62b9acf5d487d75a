"""V(n, N) and SO(N) in the metric <V, W> = tr(V Lambda W^T) of [ST] and [RB]: tangents, and parallel transport along a
geodesic whose frames are known at any time. Frames are n x N with orthonormal rows; arrays may have leading axes."""
from __future__ import annotations

from functools import cached_property
from typing import Any, Callable

import numpy as np
from numpy.typing import NDArray

from stiefel._given.typed import FieldName, Method, Scene
from stiefel._manifold.beta import transposed
from stiefel._client import Client
from stiefel.results import Outcome

Array = NDArray[np.float64]
#: Gauss's nodes and weights on [0, 1], and the integrals of the nodes' Lagrange polynomials from 0 to each node.
STAGES = 8
NODES, WEIGHTS = (np.polynomial.legendre.leggauss(STAGES)[0] + 1) / 2, np.polynomial.legendre.leggauss(STAGES)[1] / 2
_powers = np.arange(1, STAGES + 1)
INTEGRALS = (NODES[:, None] ** _powers / _powers) @ np.linalg.inv(np.vander(NODES, increasing=True))


def lyapunov(K: Array, C: Array) -> Array:
    """Returns the B of KB + BK = C, with K symmetric and positive; it is symmetric or skew if C is."""
    kappa, X = np.linalg.eigh(K)
    return np.asarray(X @ ((transposed(X) @ C @ X) / (kappa[..., :, None] + kappa[..., None, :])) @ transposed(X))


def solve(derivative: Callable[[NDArray[np.int64], Array], Array], W: Array, steps: int) -> Array:
    """Solves the linear equation W' = derivative(node, W) from 0 to 1 by Gauss's method of order 16.

    `derivative` gets the index of the time (step * STAGES + stage) along the first axis of both arguments.
    """
    h = 1 / steps
    for step in range(steps):
        nodes = np.arange(STAGES) + step * STAGES
        slopes = np.zeros((STAGES,) + W.shape)
        for _ in range(60):  # the fixed point converges as (h |Omega|)^k
            last = slopes
            slopes = derivative(nodes, W + h * np.tensordot(INTEGRALS, slopes, 1))
            if np.max(np.abs(slopes - last), initial=0.0) <= 1e-16 * np.max(np.abs(slopes), initial=0.0):
                break
        W = W + h * np.tensordot(WEIGHTS, slopes, 1)
    return W


class InertiaMetric:
    """The metric of one Lambda. A server follows its geodesics, as motions of `rigid_body` (n = N) or `stiefel`."""

    #: the method on V(n, N), whose error of a unit of time is that of rounding
    METHOD: Method = {"name": "adaptive", "tolerance": 1e-14}
    MOST_STEPS = 256  #: of the transport, each with STAGES nodes

    def __init__(self, inertia: Array, client: Callable[[], Client]):
        self.inertia, self._client = inertia, client
        self.request: dict[str, Any] = {"metric": "lambda", "inertia": inertia}

    @cached_property
    def _scale(self) -> Array:
        """lambda_i + lambda_j, the factors of J(X) = X Lambda + Lambda X for skew X: N x N, which frames with n < N do not need."""
        factors: Array = self.inertia[:, None] + self.inertia
        np.fill_diagonal(factors, 1.0)  # the diagonal of skew matrices is 0
        return factors

    def __repr__(self) -> str:
        return f"Lambda = {self.inertia}"

    def inner(self, Q: Array, V: Array, W: Array) -> Array:
        return np.asarray(np.sum(V * self.inertia * W, axis=(-2, -1)))

    def tangent(self, Q: Array, Z: Array) -> Array:
        if Q.shape[-2] == len(self.inertia):  # QX with J(X) = X Lambda + Lambda X the skew part of 2 Q^T Z Lambda
            X = transposed(Q) @ Z * self.inertia
            return Q @ ((X - transposed(X)) / self._scale)
        ZQ = Z @ transposed(Q)
        return Z - lyapunov(self._gram(Q), ZQ + transposed(ZQ)) @ (Q / self.inertia)

    def gradient(self, Q: Array, G: Array) -> Array:
        """Returns the gradient of a function whose matrix of partial derivatives is G."""
        if Q.shape[-2] == len(self.inertia):
            B = transposed(Q) @ G
            return Q @ ((B - transposed(B)) / self._scale)
        return self.tangent(Q, G / self.inertia)

    def hessian(self, Q: Array, G: Array, G_V: Array, V: Array) -> Array:
        """Returns the covariant derivative of the gradient along V, where G_V is the derivative of G along V."""
        if Q.shape[-2] == len(self.inertia):
            B, changed = transposed(Q) @ G, transposed(V) @ G + transposed(Q) @ G_V
            x, x_V = ((X - transposed(X)) / self._scale for X in (B, changed))
            return Q @ (x_V - self._turned_in_body(transposed(Q) @ V, x))
        ZQ = G / self.inertia @ transposed(Q)
        B = lyapunov(self._gram(Q), ZQ + transposed(ZQ))
        return self.tangent(Q, (G_V - B @ V) / self.inertia)

    def momentum(self, Q: Array, V: Array) -> Array:
        SQ = V * self.inertia @ transposed(Q)
        return SQ - transposed(SQ)

    def turn(self, Q: Array, m: Array) -> Array:
        """Returns the velocity AQ with the momentum m: FA + AF = m, F = Q Lambda Q^T."""
        return lyapunov(Q * self.inertia @ transposed(Q), m) @ Q

    def flow(self, Q: Array, V: Array, times: Array) -> Array:
        return self._motion(Q, V, times)[0]

    def transport(self, Q: Array, V: Array, W: Array) -> Array:
        """Solves the equation of parallel transport with 1, 2, 4, ... steps until two results agree to 1e-13."""
        whole = Q.shape[-2] == len(self.inertia)
        steps, last = 1, None
        while True:
            times = np.append((np.arange(steps)[:, None] + NODES).ravel() / steps, 1.0)
            frames, velocities = self._motion(Q, V, times)
            if whole:
                Omega = transposed(frames) @ velocities
                w = solve(lambda k, w: self._turned_in_body(Omega[k], w), transposed(Q) @ W, steps)
                result: Array = frames[-1] @ w
            else:
                result = solve(lambda k, W: self._turned(frames[k], velocities[k], W), W, steps)
            if last is not None and np.max(np.abs(result - last), initial=0.0) <= 1e-13 * np.max(np.abs(W), initial=0.0):
                return result
            if steps == self.MOST_STEPS:
                raise ArithmeticError(f"the transport needs more than {steps} steps: divide the velocity")
            steps, last = 2 * steps, result

    def _gram(self, Q: Array) -> Array:
        return np.asarray(Q / self.inertia @ transposed(Q))

    def _turned(self, Q: Array, Qdot: Array, W: Array) -> Array:
        """Returns W' of a vector that is parallel along Q(t) on V(n, N): it is normal to the manifold, B Q / Lambda."""
        C = W @ transposed(Qdot)
        return np.asarray(-lyapunov(self._gram(Q), C + transposed(C)) @ (Q / self.inertia))

    def _turned_in_body(self, Omega: Array, w: Array) -> Array:
        """Returns w' of a vector Qw that is parallel along a rotation Q' = Q Omega of SO(N):

            w' = 1/2 (J^-1 ([J Omega, w] + [J w, Omega]) - [Omega, w]),   J(X) = Lambda X + X Lambda.
        """
        M, m = self._scale * Omega, self._scale * w
        brackets = M @ w - w @ M + m @ Omega - Omega @ m
        return np.asarray((brackets / self._scale - Omega @ w + w @ Omega) / 2)

    def _motion(self, Q: Array, V: Array, times: Array) -> tuple[Array, Array]:
        """Returns frames and velocities at the times, which are the first axis."""
        n, N = Q.shape[-2:]
        whole = n == N
        Omega = transposed(Q) @ V
        # A short vector may be tangent only to the rounding of the numbers from which it comes.
        name: FieldName = "M" if whole else "S"
        second = self._scale * (Omega - transposed(Omega)) / 2 if whole else self.tangent(Q, V) * self.inertia
        blocks: Any = {"Q": Q.reshape(-1, n, N), name: second.reshape(-1, n, N)}
        scene: Scene = {"system": "rigid_body" if whole else "stiefel", "inertia": self.inertia.tolist(), "step": 1.0,
                        "members": len(blocks["Q"]), "initial": blocks}
        if N > 3:
            scene["method"] = self.METHOD
        with self._client().create(scene) as session:
            run = session.trajectory(times=times.tolist(), fields=["Q", name])
            if run.outcome != Outcome.REACHED:
                raise ArithmeticError(f"the geodesic ended with {run.outcome}: {run.run_status.message}")
            frames, state = (np.reshape(run[one], times.shape + Q.shape) for one in ("Q", name))
        return frames, frames @ (state / self._scale) if whole else state / self.inertia
