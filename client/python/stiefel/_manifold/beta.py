"""Geodesics of V(n, N) in the metrics <V, W> = beta tr(A^T B) + tr(H^T K) of Hüper, Markina and Silva Leite (2021).

U is N x n with orthonormal columns, and V = U A + U_perp H, W = U B + U_perp K with skew A, B. beta = 1 is the Euclidean
metric, beta = 1/2 the canonical one. Arrays may have leading axes. With columns [U C] that span U and V, and R = C^T V,

    exp_U(V) = [U C] exp(Xi) [I; 0] exp((1 - 2 beta) A),   Xi = [[2 beta A, -R^T], [R, 0]].
"""
from __future__ import annotations

from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROUNDING = 1e-13  # of products of frames
FRAME_TOLERANCE = 1e-6  #: of frames, as in a scene
SMALL = 64  #: numbers of a frame that is not worth a span


def transposed(A: Array) -> Array:
    return np.swapaxes(A, -1, -2)


def skew_part(A: Array) -> Array:
    return (A - transposed(A)) / 2


def rotation(A: Array) -> Array:
    """Returns exp(A) of skew A, from the eigenvalues of the Hermitian iA."""
    theta, X = np.linalg.eigh(1j * A)
    return np.asarray(np.real(X * np.exp(-1j * theta)[..., None, :] @ np.conj(transposed(X))))


def defect(Q: Array) -> Array:
    """Returns max |QQ^T - I| of each frame."""
    return np.asarray(np.max(np.abs(Q @ transposed(Q) - np.eye(Q.shape[-2])), axis=(-2, -1), initial=0.0))


def polished(Q: Array, defects: Array) -> Array:
    """Returns frames (pairs, n, N); those that are orthonormal to 1e-6 become orthonormal to rounding."""
    rounded = (defects > ROUNDING)[:, None, None]
    for _ in range(2 if np.any(rounded) else 0):  # the defect becomes 3/4 of its square
        Q = np.where(rounded, (3 * np.eye(Q.shape[-2]) - Q @ transposed(Q)) @ Q / 2, Q)
    return Q


class Span:
    """Frames Q and P, (pairs, n, N) with N > 2n, in orthonormal bases [Q; K] of their spans. No metric of beta changes under
    rotations of R^N, so that geodesics from Q to P lie there."""

    def __init__(self, Q: Array, P: Array):
        n = Q.shape[-2]
        inside = P @ transposed(Q)
        self.Q, self.K = Q, _complement(Q, P, inside)
        self.start = np.broadcast_to(np.eye(n, 2 * n), inside.shape[:-1] + (2 * n,))
        end = np.concatenate([inside, P @ transposed(self.K)], axis=-1)
        equal = np.max(np.abs(end - self.start), axis=(-2, -1), keepdims=True, initial=0.0) < 1e-14
        self.end = np.where(equal, self.start, end)

    def lifted(self, pair: int, X: Array) -> Array:
        """Returns matrices (..., n, N) of those in the basis of a pair, (..., n, 2n): frames, or velocities at `start`."""
        n = self.Q.shape[-2]
        return np.asarray(X[..., :n] @ self.Q[pair] + X[..., n:] @ self.K[pair])


def span_of(pairs: Sequence[tuple[Any, Any]], inertia: Sequence[float]) -> Optional[Span]:
    """Returns the span of pairs of frames. None where they are small or have not N > 2n, where they are none to
    FRAME_TOLERANCE, and where the numbers of Lambda, if it has any, differ."""
    frames = [frame for pair in pairs for frame in pair]
    if not all(isinstance(one, np.ndarray) and one.dtype.kind == "f" and one.shape == frames[0].shape for one in frames):
        return None
    n, N = frames[0].shape if frames and frames[0].ndim == 2 else (1, 0)
    if n * N <= SMALL or N <= 2 * n or len(set(inertia)) > 1 or len(inertia) not in (0, N):
        return None
    ends = [np.asarray(frames[k], float)[None] if len(pairs) == 1 else np.array(frames[k::2], float) for k in (0, 1)]
    defects = [defect(one) for one in ends]
    return Span(*map(polished, ends, defects)) if np.max(defects) <= FRAME_TOLERANCE else None


def _complement(Q: Array, P: Array, inside: Array) -> Array:
    """Returns n orthonormal vectors that are orthogonal to Q and with Q span P. inside = P Q^T."""
    n = Q.shape[-2]
    K, R = np.linalg.qr(transposed(P - inside @ Q))
    slanted = np.min(np.abs(np.diagonal(R, axis1=-2, axis2=-1)), axis=-1) < 1e-2
    if np.any(slanted):  # some of K is the rounding of P - inside Q, and need not be orthogonal to Q
        both = np.concatenate([transposed(Q[slanted]), K[slanted]], axis=-1)
        K[slanted] = np.linalg.qr(both)[0][..., n:]
    return transposed(K)


class Geodesic:
    """The geodesic from U with the velocity V, both (..., N, n)."""

    def __init__(self, U: Array, V: Array, beta: float):
        n = U.shape[-1]
        self.beta = beta
        frame = np.linalg.qr(np.concatenate([U, V], axis=-1))[0]
        self.UC = np.concatenate([U, frame[..., n:]], axis=-1)  # QR gives the columns of U up to their signs
        self.A = skew_part(transposed(U) @ V)
        self.R = transposed(self.UC[..., n:]) @ V
        top = np.concatenate([2 * beta * self.A, -transposed(self.R)], axis=-1)
        bottom = np.concatenate([self.R, np.zeros(self.R.shape[:-1] + self.R.shape[-2:-1])], axis=-1)
        self.Xi = np.concatenate([top, bottom], axis=-2)

    def at(self, t: Any) -> Array:
        """Returns the frame at time t, a number or an array of the leading axes."""
        return self._moved(t, np.eye(self.UC.shape[-1])[:, :self.A.shape[-1]])

    def transport(self, W: Array) -> Array:
        """Returns the tangent vector W of U, transported in parallel along the geodesic to time 1.

        V(n, N) is naturally reductive in these metrics. Seen from the moving frame, [B; K] of W obeys the linear equation

            B' = -1/2 ((4 beta - 1) [A, B] - H^T K + K^T H),   K' = beta (K A - H B),

        and what is orthogonal to U and V is multiplied by exp(beta A).
        """
        A, H, beta, n = self.A, self.R, self.beta, self.A.shape[-1]

        def derivative(W: Array) -> Array:
            B, K = W[..., :n, :], W[..., n:, :]
            AB, HK = A @ B, transposed(H) @ K
            return np.concatenate([((AB - transposed(AB)) * (1 - 4 * beta) + HK - transposed(HK)) / 2, beta * (K @ A - H @ B)], axis=-2)

        inside = transposed(self.UC) @ W
        norm = np.max(np.linalg.norm(A, axis=(-2, -1)) + np.linalg.norm(H, axis=(-2, -1)), initial=0.0) * (1 + 4 * beta)
        turned, steps = np.concatenate([skew_part(inside[..., :n, :]), inside[..., n:, :]], axis=-2), max(1, int(np.ceil(norm)))
        for _ in range(steps):  # by Taylor series of a norm below 1, whose term 22 is below the rounding: 1 / 22! = 1e-21
            term = turned
            for k in range(1, 22):
                term = derivative(term) / (steps * k)
                turned = turned + term
        return self._moved(1.0, turned) + (W - self.UC @ inside) @ rotation((1 - beta) * A)

    def _moved(self, t: Any, x: Array) -> Array:
        t = np.asarray(t, float)[..., None, None]
        return self.UC @ rotation(t * self.Xi) @ x @ rotation((1 - 2 * self.beta) * t * self.A)


class BetaMetric:
    """The metric of one beta. Frames and vectors are n x N here, as everywhere in stiefel."""

    def __init__(self, beta: float):
        self.beta = beta
        #: what Connect is asked for
        self.request: dict[str, Any] = {"metric": "euclidean"} if beta == 1 else {"metric": "beta", "beta": beta}

    def __repr__(self) -> str:
        return {1.0: "Euclidean metric, ", 0.5: "canonical metric, "}.get(self.beta, "") + f"beta = {self.beta:g}"

    def inner(self, Q: Array, V: Array, W: Array) -> Array:
        product: Array = np.sum(V * W, axis=(-2, -1))
        if self.beta == 1:
            return product
        along = np.sum((V @ transposed(Q)) * (W @ transposed(Q)), axis=(-2, -1))
        return product - (1 - self.beta) * np.asarray(along)

    def tangent(self, Q: Array, Z: Array) -> Array:
        A = Z @ transposed(Q)
        return Z - (A + transposed(A)) / 2 @ Q

    def gradient(self, Q: Array, G: Array) -> Array:
        """Returns the gradient of a function whose matrix of partial derivatives is G."""
        A = skew_part(G @ transposed(Q))
        return A @ Q / self.beta + G - G @ transposed(Q) @ Q

    def hessian(self, Q: Array, G: Array, G_V: Array, V: Array) -> Array:
        """Returns the covariant derivative of the gradient along V, where G_V is the derivative of G along V."""
        A, A_V = skew_part(G @ transposed(Q)), skew_part(G_V @ transposed(Q) + G @ transposed(V))
        changed = ((A_V @ Q + A @ V) / self.beta + G_V - G_V @ transposed(Q) @ Q
                   - G @ transposed(V) @ Q - G @ transposed(Q) @ V)
        W = self.gradient(Q, G)
        return changed - (self._acceleration(Q, V + W) - self._acceleration(Q, V - W)) / 4

    def _acceleration(self, Q: Array, V: Array) -> Array:
        """Returns the second derivative of a geodesic, a quadratic form of the velocity V."""
        A = V @ transposed(Q)
        H = V - A @ Q
        return (A @ A - H @ transposed(H)) @ Q + 2 * (1 - self.beta) * A @ H

    def momentum(self, Q: Array, V: Array) -> Array:
        return 2 * self.beta * skew_part(V @ transposed(Q))

    def turn(self, Q: Array, m: Array) -> Array:
        """Returns the velocity AQ with the momentum m = 2 beta A."""
        return m / (2 * self.beta) @ Q

    def flow(self, Q: Array, V: Array, times: Array) -> Array:
        geodesic = self._geodesic(Q, V)
        return np.stack([transposed(geodesic.at(t)) for t in times])

    def transport(self, Q: Array, V: Array, W: Array) -> Array:
        return transposed(self._geodesic(Q, V).transport(transposed(W)))

    def _geodesic(self, Q: Array, V: Array) -> Geodesic:
        return Geodesic(transposed(Q), transposed(V), self.beta)
