"""Fréchet means of frames, by their logarithms."""
from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Mean:
    """Fréchet means of frames. Arrays have the leading axes of the points but the last, which is that of the points."""

    frame: Array
    residual: Array  #: the norm of the weighted mean of the logarithms at `frame`, which is 0 at a mean
    variance: Array  #: the weighted mean of the squared distances from `frame`
    converged: NDArray[np.bool_]  #: whether the residual is below the tolerance
    proved: NDArray[np.bool_]  #: whether each geodesic from `frame` to a point is proved to be the shortest
    iterations: int

    def __repr__(self) -> str:
        failed = int(np.sum(~self.converged))
        return (f"<stiefel.manifold.Mean {self.frame.shape}: residual at most {np.max(self.residual, initial=0.0):.1e} after "
                f"{self.iterations} iterations{f', {failed} not converged' if failed else ''}>")


def mean_of(manifold: Any, points: ArrayLike, weights: Optional[ArrayLike], tolerance: float, most: int) -> Mean:
    """Does what `Stiefel.mean` says."""
    frames, metric, own = manifold._frame(points), manifold._metric, (-2, -1)
    if frames.ndim < 3 or not frames.shape[-3]:
        raise ValueError(f"points: the shape {np.shape(points)}: must be (..., points, {manifold.shape[0]}, {manifold.shape[1]}), one point or more")
    shares = np.ones(frames.shape[:-2]) if weights is None else np.asarray(weights, float)
    if shares.shape not in (frames.shape[-3:-2], frames.shape[:-2]) or not np.all(shares >= 0) or not np.all(np.isfinite(shares)) or not np.all(np.any(shares, -1)):
        raise ValueError(f"weights: must be {frames.shape[-3]} numbers of at least 0 with a positive sum, for each of the means or for all")
    shares = np.broadcast_to(shares / shares.sum(-1, keepdims=True), frames.shape[:-2])[..., None, None]
    near = np.sum((frames - np.sum(shares * frames, axis=-3, keepdims=True))**2, axis=own, keepdims=True)
    X = np.take_along_axis(frames, np.argmin(near, axis=-3, keepdims=True), axis=-3)
    last = X, X
    for iterations in range(most + 1):
        joined = manifold.join(manifold._out(X), manifold._out(frames))
        step = np.sum(shares * manifold._in(joined.velocity), axis=-3, keepdims=True)
        residual = np.sqrt(metric.inner(X, step, step))[..., 0]
        variance = np.sum(shares[..., 0, 0] * joined.distance**2, axis=-1)
        converged = residual <= tolerance * np.sqrt(variance)
        if converged.all() or iterations == most:
            break
        moved, turned = X - last[0], last[1] - step
        square, product = (np.sum(moved * one, axis=own, keepdims=True) for one in (moved, turned))
        length = np.clip(np.divide(square, product, out=np.ones(product.shape), where=product > 0), 0.2, 3.0)
        last = X, step
        X = metric.flow(X, metric.tangent(X, length * step), np.ones(1))[0]
    if not converged.all():
        warnings.warn(f"{np.sum(~converged)} of {converged.size} means did not converge in {most} iterations: the residual is "
                      f"{np.max(residual):.1e}", stacklevel=3)
    return Mean(manifold._out(X[..., 0, :, :]), residual, variance, converged, np.all(joined.shortest == "yes", axis=-1), iterations)
