"""Runs inside an environment with pymanopt and geomstats: their own checks of manifolds, on those of stiefel.manifold."""
import contextlib
import io
import re
from pathlib import Path

import geomstats.backend as backend
import numpy as np
import pymanopt
import pymanopt.optimizers
import pymanopt.tools.diagnostics as diagnostics
from geomstats.test.random import RandomDataGenerator
from geomstats.test_cases.geometry.riemannian_metric import RiemannianMetricTestCase

from stiefel.manifold import SpecialOrthogonal, Stiefel

PAGE = (Path(__file__).resolve().parents[2] / "docs/manifolds.md").read_text(encoding="utf-8")
RECIPE = {}
exec(re.search(r"```py\n(.*?)```", PAGE, re.DOTALL)[1], RECIPE)

FRAMES = [Stiefel(3, 6), Stiefel(3, 6, "canonical"), Stiefel(2, 4, [1, 2, 3, 0.5]), SpecialOrthogonal(4), SpecialOrthogonal(3, [1, 2, 0.3])]
COLUMNS = [Stiefel(2, 5, layout="columns"), Stiefel(2, 5, "canonical", layout="columns"), Stiefel(2, 4, [1, 2, 3, 1.5], layout="columns"),
           SpecialOrthogonal(3, layout="columns")]
RANDOM = ["exp_belongs", "log_is_tangent", "exp_after_log", "log_after_exp", "exp_geodesic_ivp", "inner_product_is_symmetric",
          "norm_is_positive", "normalize_is_unitary", "squared_dist_is_symmetric", "squared_dist_is_positive", "dist_is_log_norm",
          "parallel_transport_ivp_transported_is_tangent", "parallel_transport_bvp_transported_is_tangent", "parallel_transport_ivp_norm"]
VECTORISED = ["exp_vec", "log_vec", "inner_product_vec", "norm_vec", "dist_vec", "parallel_transport_ivp_vec", "parallel_transport_bvp_vec"]


def residuals_of(check, problem, *at):
    """Returns the residuals that a check of pymanopt prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        check(problem, *at)
    return [float(x) for x in re.findall(r"[Rr]esidual[^:]*(?:0|close)[^:]*: ([-+.\de]*\d)", printed.getvalue())]


def with_pymanopt(manifold):
    adapted = manifold.to_pymanopt()
    n, N = manifold.shape
    A, D = np.random.default_rng(1).normal(size=(N, N)), np.diag(np.arange(1.0, n + 1))
    A = A + A.T
    cost = pymanopt.function.numpy(adapted)(lambda Q: float(np.trace(D @ Q @ A @ Q.T)))
    gradient = pymanopt.function.numpy(adapted)(lambda Q: 2 * D @ Q @ A)
    hessian = pymanopt.function.numpy(adapted)(lambda Q, V: 2 * D @ V @ A)
    problem = pymanopt.Problem(adapted, cost, euclidean_gradient=gradient, euclidean_hessian=hessian)
    # The checks fit the slope of the Taylor remainder, 2 for a gradient and 3 for a Hessian, and return nothing. At a point where
    # the coefficient of h^3 happens to be small the slope is that of h^4, so that points are not drawn anew.
    point = manifold.random(seed=7)
    at = point, manifold.random_tangent(point, seed=8)
    fitted = []
    find = diagnostics.identify_linear_piece
    diagnostics.identify_linear_piece = lambda *given: fitted.append(find(*given)) or fitted[-1]
    residuals = residuals_of(diagnostics.check_gradient, problem, *at) + residuals_of(diagnostics.check_hessian, problem, *at)
    diagnostics.identify_linear_piece = find
    assert abs(fitted[0][1][0] - 2) < 0.05 and abs(fitted[1][1][0] - 3) < 0.1, (manifold, fitted)
    assert residuals and max(residuals) < 1e-11, (manifold, residuals)
    found = pymanopt.optimizers.TrustRegions(verbosity=0, min_gradient_norm=1e-9).run(problem, initial_point=manifold.random(seed=3))
    assert found.gradient_norm < 1e-6, (manifold, found)
    if isinstance(manifold, Stiefel):  # Brockett's function: the largest weight with the smallest eigenvalue
        expected = np.dot(np.linalg.eigvalsh(A)[:n], np.arange(n, 0, -1))
        assert abs(found.cost - expected) < 1e-7 * abs(expected), (manifold, found.cost, expected)


def with_geomstats(manifold):
    space = RECIPE["geomstats_space"](manifold)
    case = RiemannianMetricTestCase()
    case.space = space
    case.data_generator = RandomDataGenerator(space, amplitude=4.0)
    ran = 0
    for name in RANDOM:
        backend.random.seed(1)
        getattr(case, f"test_{name}")(n_points=3, atol=1e-11)
        ran += 1
    for name in VECTORISED:
        if hasattr(case, f"test_{name}"):
            getattr(case, f"test_{name}")(n_reps=3, atol=1e-11)
            ran += 1
    assert ran > len(RANDOM)


if __name__ == "__main__":
    import matplotlib.pyplot

    matplotlib.pyplot.switch_backend("agg")
    for manifold in FRAMES:
        with_pymanopt(manifold)
        print("pymanopt", manifold)
    for manifold in COLUMNS:
        with_geomstats(manifold)
        print("geomstats", manifold)
