"""Manifolds of frames with exp, log and parallel transport: `Stiefel` and `SpecialOrthogonal`.

    S = stiefel.manifold.Stiefel(3, 8)
    Q, P = S.random(2)
    V = S.log(Q, P)
    S.exp(Q, V / 2)                          # the midpoint of the geodesic

Frames are n x N with orthonormal rows, or with layout="columns" N x n with orthonormal columns. Every function takes
leading axes, over which it repeats: `S.exp(Q, V)` of (100, n, N) arrays is 100 geodesics. Closed forms are computed
here; where a metric has none, a server of the process's own follows the geodesics, or that of `client`.

exp, geodesic, transport, join, log and dist raise ValueError for frames and tangent vectors that are none to 1e-6.
"""
from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiefel._manifold.beta import FRAME_TOLERANCE, BetaMetric, defect
from stiefel._manifold.inertia import InertiaMetric
from stiefel._manifold.means import Mean, mean_of
from stiefel._results.extras import imported, progress_bar
from stiefel._client import Client
from stiefel.errors import StiefelError
from stiefel.results import Geodesic
from stiefel.simulation import own_client

__all__ = ["Joined", "Mean", "NotJoined", "SpecialOrthogonal", "Stiefel"]
__dir__ = lambda: sorted(__all__)  # noqa: E731

Array = NDArray[np.float64]
MOST_PAIRS = 1024  #: pairs of one call of Connect
SUMS = 1e-12  #: the rounding of a sum of vectors of length 1, such as the mean of logarithms, which may cancel


class NotJoined(StiefelError):
    """No geodesic was found between two frames. `pairs` has the indices of these pairs."""

    def __init__(self, pairs: Sequence[int], of: int, reason: str):
        super().__init__(f"{len(pairs)} of {of} pairs of frames were not joined. Pair {pairs[0]}: {reason}; partial=True gives NaN for it"
                         " and the geodesics of the others")
        self.pairs = tuple(pairs)


@dataclass(frozen=True)
class Joined:
    """The geodesics from frames Q to frames P in the time 1. Arrays have the leading axes of Q and P. Where none was found,
    numbers are NaN, and `shortest` is "unknown"."""

    velocity: Array  #: V with exp(Q, V) = P
    distance: Array  #: the norm of V, which is the length
    residual: Array  #: max |exp(Q, V) - P|
    #: "yes": the geodesic is proved to be the shortest; "none_shorter_found": a search found no shorter one;
    #: "no": a shorter path exists; "unknown": nothing was searched or proved; "ended": a search was ended before
    shortest: NDArray[np.str_]

    def __repr__(self) -> str:
        found = np.isfinite(self.distance)
        near, far, worst = (float(end(values[found])) if found.any() else np.nan for end, values in (
            (np.min, self.distance), (np.max, self.distance), (np.max, self.residual)))
        pairs = f"{found.size} pair{'s' * (found.size != 1)}" + f", {np.sum(~found)} not joined" * (not found.all())
        kinds = ", ".join(f"{kind} {count}" for kind, count in zip(*np.unique(self.shortest, return_counts=True)))
        return f"<stiefel.manifold.Joined of {pairs}: distance {near:.6g} to {far:.6g}, residual at most {worst:.1e}\n  shortest: {kinds}>"


class _Manifold:
    """What the manifolds of frames share. Private functions see n x N frames."""

    def __init__(self, n: int, N: int, metric: Union[BetaMetric, InertiaMetric], layout: str, client: Optional[Client]):
        if layout not in ("rows", "columns"):
            raise ValueError(f"layout: {layout!r}: must be 'rows' (n x N frames) or 'columns' (N x n)")
        self.n, self.N, self.layout = n, N, layout
        self.shape = (n, N) if layout == "rows" else (N, n)  #: of one frame
        self.dim = n * N - n * (n + 1) // 2  #: of the manifold
        self._metric, self._own_client = metric, client

    def inner(self, Q: ArrayLike, V: ArrayLike, W: ArrayLike) -> Array:
        """Returns the inner product of tangent vectors V and W at Q."""
        return self._metric.inner(self._in(Q), self._in(V), self._in(W))

    def norm(self, Q: ArrayLike, V: ArrayLike) -> Array:
        """Returns the norm of the tangent vector V at Q."""
        return np.asarray(np.sqrt(self.inner(Q, V, V)))

    def tangent(self, Q: ArrayLike, Z: ArrayLike) -> Array:
        """Returns the orthogonal projection of any matrix Z onto the tangent space at Q."""
        return self._out(self._tangent(self._in(Q), self._in(Z)))

    def gradient(self, Q: ArrayLike, derivative: ArrayLike) -> Array:
        """Returns the Riemannian gradient at Q of a function whose matrix of partial derivatives is `derivative`."""
        return self._out(self._tangent(self._in(Q), self._metric.gradient(self._in(Q), self._in(derivative))))

    def hessian(self, Q: ArrayLike, derivative: ArrayLike, changed: ArrayLike, V: ArrayLike) -> Array:
        """Returns the Riemannian Hessian of a function, applied to the tangent vector V at Q.

        `derivative`: its matrix of partial derivatives at Q; `changed`: the derivative of that matrix along V.
        """
        frames = self._in(Q)
        return self._out(self._tangent(frames, self._metric.hessian(frames, self._in(derivative), self._in(changed), self._in(V))))

    def project(self, Z: ArrayLike) -> Array:
        """Returns the frame that is nearest to the matrix Z, its polar factor."""
        return self._out(self._nearest(self._in(Z)))

    def random(self, size: Union[int, tuple[int, ...]] = (), *, seed: Any = None) -> Array:
        """Returns frames that are uniformly distributed, with `size` as leading axes."""
        axes = (size,) if isinstance(size, int) else tuple(size)
        return self._out(self._nearest(np.random.default_rng(seed).normal(size=axes + (self.n, self.N))))

    def random_tangent(self, Q: ArrayLike, *, seed: Any = None) -> Array:
        """Returns a random tangent vector of norm 1 at each frame of Q. `seed` may be that of `random`."""
        frames = self._in(Q)
        if seed is None or isinstance(seed, (int, np.integer)):  # the numbers of random(seed) span Q, and have no tangent part
            seed = np.random.SeedSequence(seed, spawn_key=(1,))
        V = self._metric.tangent(frames, np.random.default_rng(seed).normal(size=frames.shape))
        return self._out(V / np.sqrt(self._metric.inner(frames, V, V))[..., None, None])

    def momentum(self, Q: ArrayLike, V: ArrayLike) -> Array:
        """Returns the skew n x n matrix m of the turns of the frame in itself: inner(V, AQ) = tr(m A^T) / 2 for skew A. A
        geodesic keeps it. In the metric of Lambda, m = SQ^T - QS^T with S = V Lambda."""
        return self._metric.momentum(self._in(Q), self._in(V))

    def velocity(self, Q: ArrayLike, direction: ArrayLike, *, energy: float = 0.5, momentum: Optional[ArrayLike] = None) -> Array:
        """Returns the velocity at Q with the energy inner(V, V) / 2 and the momentum (by default 0), n x n.

        It is the sum of the velocity of least energy with this momentum, which turns the frame in itself, and of a multiple
        of the part of `direction` whose momentum is 0. Raises ValueError where there is none: the energy is below the least,
        or nothing of `direction` has the momentum 0.
        """
        frames = self._frame(Q)
        m = np.zeros((self.n, self.n)) if momentum is None else np.asarray(momentum, float)
        if m.shape[-2:] != (self.n, self.n) or np.max(np.abs(m + np.swapaxes(m, -1, -2)), initial=0.0) > 1e-12 * np.max(np.abs(m), initial=0.0):
            raise ValueError(f"momentum: must be a skew-symmetric {self.n} x {self.n} matrix")
        W = self._metric.tangent(frames, self._in(direction))
        turn, free = self._metric.turn(frames, m), W - self._metric.turn(frames, self._metric.momentum(frames, W))
        least, rest = (self._metric.inner(frames, part, part) / 2 for part in (turn, free))
        if np.any(least > energy):
            raise ValueError(f"energy: {energy!r}: must be at least {np.max(least)!r} at this frame with this momentum")
        if np.any(rest <= 1e-24 * self._metric.inner(frames, W, W)):
            raise ValueError("direction: must have a part whose momentum is 0")
        return self._out(turn + np.sqrt((energy - least) / rest)[..., None, None] * free)

    def exp(self, Q: ArrayLike, V: ArrayLike) -> Array:
        """Returns the frame at time 1 of the geodesic that starts at Q with the velocity V."""
        return np.asarray(self.geodesic(Q, V, 1.0)[0])

    def geodesic(self, Q: ArrayLike, V: ArrayLike, times: ArrayLike) -> Array:
        """Returns the frames at `times`, a first axis, of the geodesic that starts at Q with the velocity V."""
        frames = self._frame(Q)
        frames, vectors = self._same(frames, self._vector(frames, V))
        return self._out(self._metric.flow(frames, vectors, np.asarray(times, float).reshape(-1)))

    def transport(self, Q: ArrayLike, V: ArrayLike, W: ArrayLike) -> Array:
        """Returns the tangent vector W of Q, transported in parallel along the geodesic with velocity V to exp(Q, V)."""
        frames = self._frame(Q)
        return self._out(self._metric.transport(*self._same(frames, self._vector(frames, V), self._vector(frames, W))))

    def join(self, Q: ArrayLike, P: ArrayLike, *, restarts: int = 0, seed: int = 0, partial: bool = False, progress: bool = False) -> Joined:
        """Returns the geodesics from Q to P and what is known of them.

        `restarts`: how many searches for shorter geodesics start from random paths. `partial`: gives NaN where no geodesic is
        found; else raises NotJoined. `progress`: shows a progress bar of tqdm.
        """
        frames, others = self._same(self._frame(Q), self._frame(P))
        starts, ends = frames.reshape(-1, self.n, self.N), others.reshape(-1, self.n, self.N)
        found: list[Geodesic] = []
        some = min(MOST_PAIRS, max(1, len(starts) // 100)) if progress else MOST_PAIRS
        with progress_bar(len(starts), progress, "pair") as bar:
            for first in range(0, len(starts), some):
                pairs = list(zip(starts[first:first + some], ends[first:first + some]))
                found += self._client().geodesics(pairs, restarts=restarts, seed=seed, scenes=False, **self._metric.request)
                bar.update(len(pairs))
        missed = [i for i, geodesic in enumerate(found) if geodesic.velocity is None]
        if missed and not partial:
            raise NotJoined(missed, len(found), found[missed[0]].run_status.message)
        V = np.array([np.full(frames.shape[-2:], np.nan) if one.velocity is None else one.velocity for one in found]).reshape(frames.shape)
        there = np.isfinite(V[..., 0, 0])
        V[there] = self._metric.tangent(frames[there], V[there])
        length = np.sqrt(self._metric.inner(frames, V, V))
        return Joined(self._out(V), length, np.where(there, np.reshape([one.residual for one in found], there.shape), np.nan),
                      np.where(there, np.reshape([one.shortest for one in found], there.shape), "unknown"))

    def log(self, Q: ArrayLike, P: ArrayLike, *, partial: bool = False, progress: bool = False) -> Array:
        """Returns the velocity V of a geodesic with exp(Q, V) = P: the shortest one if P is nearer than the injectivity
        radius. `join` says what is known beyond, and what `partial` and `progress` do. Raises NotJoined if none is found."""
        return self.join(Q, P, partial=partial, progress=progress).velocity

    def dist(self, Q: ArrayLike, P: ArrayLike, *, partial: bool = False, progress: bool = False) -> Array:
        """Returns the length of the geodesic that `log` finds. Warns where it is not proved to be the shortest."""
        joined = self.join(Q, P, partial=partial, progress=progress)
        unproved = int(np.sum((joined.shortest != "yes") & np.isfinite(joined.distance)))
        if unproved:
            warnings.warn(f"{unproved} of {joined.distance.size} distances are lengths of geodesics that are not proved to be the "
                          "shortest; `shortest` of join tells which, and its `restarts` search for shorter ones", stacklevel=2)
        return joined.distance

    def mean(self, points: ArrayLike, *, weights: Optional[ArrayLike] = None, tolerance: float = 1e-12, most: int = 100) -> Mean:
        """Returns the Fréchet mean of points (..., points, n, N), a frame with the least weighted sum of squared distances among
        those near it. It is unique where the points are near enough to each other.

        At a mean the weighted mean of the logarithms of the points is 0; Karcher's iteration moves along it, by a length from the
        last two steps (Barzilai and Borwein). `weights`: (points) or with the leading axes, at least 0; by default equal.
        `tolerance`: of the residual, relative to the root of the variance. Warns where it is not reached in `most` iterations,
        and raises NotJoined where a logarithm is not found.
        """
        return mean_of(self, points, weights, tolerance, most)

    def to_pymanopt(self) -> Any:
        """Returns this manifold as one of pymanopt, an optional package. Its retraction is `exp`. Vectors are projected, because
        optimisers add and subtract them, and a sum may be tangent only to the rounding of what was added."""
        exp = lambda _, point, vector: self.exp(point, self.tangent(point, vector))  # noqa: E731
        tangent = lambda _, point, vector: self.tangent(point, vector)  # noqa: E731
        return type("Frames", (imported("pymanopt.manifolds.manifold", "pymanopt").Manifold,), {
            "typical_dist": float(np.pi), "exp": exp, "retraction": exp, "projection": tangent, "to_tangent_space": tangent,
            "transport": lambda _, point, other, vector: self.transport(
                point, self.log(point, other), self.tangent(point, vector)),
            "inner_product": lambda _, point, a, b: float(self.inner(point, a, b)),
            "norm": lambda _, point, vector: float(self.norm(point, vector)),
            "euclidean_to_riemannian_gradient": lambda _, *given: self.gradient(*given),
            "euclidean_to_riemannian_hessian": lambda _, *given: self.hessian(*given),
            "log": lambda _, point, other: self.log(point, other),
            "dist": lambda _, point, other: float(self.dist(point, other)),
            "pair_mean": lambda _, point, other: self.exp(point, self.log(point, other) / 2),
            "random_point": lambda _: self.random(), "random_tangent_vector": lambda _, point: self.random_tangent(point),
            "zero_vector": lambda _, point: np.zeros(self.shape)})(repr(self), self.dim)

    def __repr__(self) -> str:
        return f"<stiefel.manifold.{type(self).__name__} of {self.shape[0]} x {self.shape[1]} frames, {self._metric!r}>"

    def _client(self) -> Client:
        return own_client() if self._own_client is None else self._own_client

    def _same(self, *arrays: Array) -> tuple[Array, ...]:
        """Returns the arrays with the same leading axes."""
        try:
            return tuple(np.broadcast_arrays(*arrays))
        except ValueError:
            axes = " and ".join(str(array.shape[:-2]) for array in arrays)
            raise ValueError(f"the leading axes {axes} do not broadcast") from None

    def _frame(self, Q: ArrayLike) -> Array:
        frames = self._in(Q)
        largest = float(np.max(defect(frames), initial=0.0))
        if not largest <= FRAME_TOLERANCE:
            raise ValueError(f"max |QQ^T - I| = {largest:.1e}: frames must have orthonormal vectors to {FRAME_TOLERANCE:g}; "
                             "project(Q) has the nearest ones")
        return frames

    def _tangent(self, Q: Array, Z: Array) -> Array:
        """Projects twice: the first time leaves the rounding of Z, beside which the tangent part may be small."""
        return self._metric.tangent(Q, self._metric.tangent(Q, Z))

    def _vector(self, Q: Array, V: ArrayLike) -> Array:
        """Returns V, each tangent at Q to the tolerance of frames, relative to its largest number, or to SUMS."""
        frames, vectors = self._same(Q, self._in(V))
        product = vectors @ np.swapaxes(frames, -1, -2)
        defects = np.max(np.abs(product + np.swapaxes(product, -1, -2)), axis=(-2, -1), initial=0.0)
        if not np.all(defects <= np.maximum(SUMS, FRAME_TOLERANCE * np.max(np.abs(vectors), axis=(-2, -1), initial=0.0))):
            raise ValueError(f"max |VQ^T + QV^T| = {np.max(defects):.1e}: must be tangent at Q; `tangent` makes it so")
        return vectors

    def _in(self, given: ArrayLike) -> Array:
        array = np.asarray(given, float)
        if array.shape[-2:] != self.shape:
            other = "columns" if self.layout == "rows" else "rows"
            raise ValueError(f"the shape {array.shape}: must end with {self.shape}, layout {self.layout!r}"
                             + f"; layout={other!r} takes this one" * (array.shape[-2:] == self.shape[::-1]))
        return array if self.layout == "rows" else np.swapaxes(array, -1, -2)

    def _out(self, array: Array) -> Array:
        return array if self.layout == "rows" else np.swapaxes(array, -1, -2)

    def _nearest(self, Z: Array) -> Array:
        left, _, right = np.linalg.svd(Z, full_matrices=False)
        if isinstance(self, SpecialOrthogonal):
            left[..., -1] *= np.sign(np.linalg.det(left @ right))[..., None]
        return np.asarray(left @ right)


class Stiefel(_Manifold):
    """The n x N frames with orthonormal rows, V(n, N), with one of these metrics on tangent vectors V = A Q + H, HQ^T = 0:

    - "euclidean": tr(V W^T);
    - "canonical": tr(V (I - Q^T Q / 2) W^T);
    - a number beta > 0: beta tr(A A'^T) + tr(H H'^T) (Hüper, Markina and Silva Leite 2021);
    - N positive numbers, Lambda: tr(V Lambda W^T), whose geodesics are the motions of [ST].

    "euclidean" is beta = 1, "canonical" beta = 1/2. `client`: the server that follows and joins what has no closed form;
    by default one of the process's own.
    """

    def __init__(self, n: int, N: int, metric: Union[str, float, Sequence[float], Array] = "euclidean", *,
                 layout: str = "rows", client: Optional[Client] = None):
        if not 1 <= n <= N:
            raise ValueError(f"n = {n}, N = {N}: must be 1 <= n <= N; Stiefel(n, N) has n vectors of N numbers")
        super().__init__(n, N, self._metric_of(metric, N), layout, client)

    def _metric_of(self, metric: Any, N: int) -> Union[BetaMetric, InertiaMetric]:
        betas = {"euclidean": 1.0, "canonical": 0.5}
        value = np.asarray(betas.get(metric, np.nan) if isinstance(metric, str) else metric, float)
        if value.ndim == 0 and value > 0:
            return BetaMetric(float(value))
        if value.shape == (N,) and np.all(value > 0):
            return InertiaMetric(value, self._client)
        raise ValueError(f"metric: {metric!r}: must be 'euclidean', 'canonical', a positive number or {N} positive numbers")

    def align(self, Q: ArrayLike, P: ArrayLike, *, signs: bool = False) -> Array:
        """Returns the frame of the subspace of P that is nearest to Q: RP with an orthogonal n x n matrix R. `signs`: R is
        diagonal, with the signs that make each vector nearest to that of Q."""
        frames, others = self._same(self._frame(Q), self._frame(P))
        product = frames @ np.swapaxes(others, -1, -2)
        if signs:
            return self._out(np.where(np.diagonal(product, axis1=-2, axis2=-1) < 0, -1.0, 1.0)[..., None] * others)
        left, _, right = np.linalg.svd(product)
        return self._out(left @ right @ others)

    @property
    def injectivity_radius(self) -> Optional[float]:
        """The length up to which geodesics are shortest and unique, where it is known; else None.

        pi for n = 1 and for "euclidean" with n < N (Zimmermann and Stoye 2024); pi sqrt(4/5) for "canonical" with 1 < n < N,
        a bound below the radius (Rentmeesters 2013); pi sqrt(2 beta) for n = N > 1, where the closed geodesics are turns of
        a plane, which have twice this length.
        """
        if isinstance(self._metric, InertiaMetric):
            return None
        if self.n == self.N:
            return math.pi * math.sqrt(2 * self._metric.beta) if self.n > 1 else None
        if self.n == 1 or self._metric.beta == 1:
            return math.pi
        return math.pi * math.sqrt(0.8) if self._metric.beta == 0.5 else None


class SpecialOrthogonal(_Manifold):
    """The rotations SO(N) with the metric tr(V Lambda W^T), whose geodesics are the motions of a free rigid body [RB].

    `inertia`: Lambda, N numbers with positive sums of two; by default the identity, the metric that is invariant from
    both sides. `client` is that of `Stiefel`.
    """

    def __init__(self, N: int, inertia: Optional[Union[Sequence[float], Array]] = None, *, layout: str = "rows",
                 client: Optional[Client] = None):
        Lambda = np.ones(N) if inertia is None else np.asarray(inertia, float)
        if Lambda.shape != (N,) or np.any((Lambda[:, None] + Lambda)[~np.eye(N, dtype=bool)] <= 0):
            raise ValueError(f"inertia: {inertia!r}: must be {N} numbers, and the sum of any two must be positive")
        equal = bool(np.all(Lambda == 1))
        super().__init__(N, N, BetaMetric(1.0) if equal else InertiaMetric(Lambda, self._client), layout, client)

    @property
    def injectivity_radius(self) -> Optional[float]:
        """The length up to which geodesics are shortest and unique: pi sqrt(2) for Lambda = I; else None, unknown."""
        return math.pi * math.sqrt(2) if isinstance(self._metric, BetaMetric) and self.N > 1 else None
