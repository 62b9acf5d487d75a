"""A manifold of `stiefel.manifold` as one of pymanopt or of geomstats. Neither package is needed elsewhere. Their optimisers add
and subtract vectors, whose sums may be tangent only to the rounding of what was added: they are projected."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from stiefel._results.extras import imported

Array = NDArray[np.float64]


def pymanopt_manifold(manifold: Any) -> Any:
    """Returns a pymanopt.manifolds.manifold.Manifold, whose retraction is the exponential map."""
    Manifold: Any = imported("pymanopt.manifolds.manifold", "pymanopt").Manifold

    class Frames(Manifold):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(repr(manifold), manifold.dim)

        @property
        def typical_dist(self) -> float:
            return float(np.pi)

        def inner_product(self, point: Array, a: Array, b: Array) -> float:
            return float(manifold.inner(point, a, b))

        def norm(self, point: Array, vector: Array) -> float:
            return float(manifold.norm(point, vector))

        def projection(self, point: Array, vector: Array) -> Any:
            return manifold.tangent(point, vector)

        to_tangent_space = projection

        def euclidean_to_riemannian_gradient(self, point: Array, derivative: Array) -> Any:
            return manifold.gradient(point, derivative)

        def euclidean_to_riemannian_hessian(self, point: Array, derivative: Array, changed: Array, vector: Array) -> Any:
            return manifold.hessian(point, derivative, changed, vector)

        def exp(self, point: Array, vector: Array) -> Any:
            return manifold.exp(point, manifold.tangent(point, vector))

        retraction = exp

        def log(self, point_a: Array, point_b: Array) -> Any:
            return manifold.log(point_a, point_b)

        def dist(self, point_a: Array, point_b: Array) -> float:
            return float(manifold.dist(point_a, point_b))

        def transport(self, point_a: Array, point_b: Array, vector: Array) -> Any:
            return manifold.transport(point_a, manifold.log(point_a, point_b), manifold.tangent(point_a, vector))

        def pair_mean(self, point_a: Array, point_b: Array) -> Any:
            return manifold.exp(point_a, manifold.log(point_a, point_b) / 2)

        def random_point(self) -> Any:
            return manifold.random()

        def random_tangent_vector(self, point: Array) -> Any:
            return manifold.random_tangent(point)

        def zero_vector(self, point: Array) -> Any:
            return np.zeros(manifold.shape)

    return Frames()


def geomstats_space(manifold: Any) -> Any:
    """Returns a geomstats space, Stiefel(N, n) or SpecialOrthogonal(N), equipped with the manifold's metric.

    Points of geomstats are N x n, so the manifold's layout must be "columns"; for n = N either will do.
    """
    backend = imported("geomstats.backend", "geomstats")
    from geomstats.geometry.riemannian_metric import RiemannianMetric
    from geomstats.geometry.special_orthogonal import SpecialOrthogonal
    from geomstats.geometry.stiefel import Stiefel

    if backend.__name__.rpartition(".")[2] not in ("numpy", "backend") or manifold.layout != "columns":
        raise ValueError(f"layout: {manifold.layout!r}: must be 'columns', N x n, as geomstats has frames")

    class Metric(RiemannianMetric):  # type: ignore[misc]
        def inner_product(self, tangent_vec_a: Array, tangent_vec_b: Array, base_point: Optional[Array] = None) -> Any:
            return manifold.inner(base_point, tangent_vec_a, tangent_vec_b)

        def squared_norm(self, vector: Array, base_point: Optional[Array] = None) -> Any:
            return manifold.inner(base_point, vector, vector)

        def exp(self, tangent_vec: Array, base_point: Array) -> Any:
            return manifold.exp(base_point, manifold.tangent(base_point, tangent_vec))

        def log(self, point: Array, base_point: Array) -> Any:
            return manifold.log(base_point, point)

        def squared_dist(self, point_a: Array, point_b: Array) -> Any:
            distance: Array = manifold.dist(point_a, point_b)**2
            return distance

        def dist(self, point_a: Array, point_b: Array) -> Any:
            return manifold.dist(point_a, point_b)

        def parallel_transport(self, tangent_vec: Array, base_point: Array, direction: Optional[Array] = None,
                               end_point: Optional[Array] = None) -> Any:
            along = manifold.log(base_point, end_point) if direction is None else direction
            return manifold.transport(base_point, *(manifold.tangent(base_point, one) for one in (along, tangent_vec)))

        def injectivity_radius(self, base_point: Optional[Array] = None) -> Any:
            radius = manifold.injectivity_radius
            if radius is None:
                raise NotImplementedError("the injectivity radius of this metric is not known")
            return radius if base_point is None else np.full(np.shape(base_point)[:-2], radius)

    n, N = manifold.n, manifold.N
    space = SpecialOrthogonal(N, equip=False) if type(manifold).__name__ == "SpecialOrthogonal" else Stiefel(N, n, equip=False)
    space.equip_with_metric(Metric)
    return space
