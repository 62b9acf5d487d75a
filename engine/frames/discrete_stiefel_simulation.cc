#include "engine/frames/body/discrete_stiefel.h"
#include "engine/frames/body/stiefel_invariants.h"
#include "engine/frames/stiefel_forms.h"
#include "engine/linalg/lie/orthogonal.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_discrete_stiefel(const Scene& scene) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  const int rows = static_cast<int>(n);
  const Eigen::VectorXd lambda = scene.inertia();
  StackedObservables observables(stacked(scene, "Q_prev", "Q"));
  observables.block("Q_prev", 0, rows).block("Q", rows, rows);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    using Wide = long double;
    const Matrix<Wide> Q_prev = x.topRows(n).cast<Wide>(), Q = x.bottomRows(n).cast<Wide>();
    const Vector<Wide> wide_lambda = lambda.cast<Wide>();
    if (out.wants(family::spatial_momentum)) {
      const Matrix<Wide> m = discrete_momentum<Wide>(wide_lambda, Q_prev, Q);
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = i + 1; j < n; ++j)
          out.add(family::spatial_momentum, indexed(family::spatial_momentum, i, j), m(i, j),
                  wide_lambda.maxCoeff());
    }
    if (!out.wants(family::lax, N <= largest_lax_unasked)) return;
    const int K = static_cast<int>(N);
    const auto coefficients = discrete_lax_coefficients<Wide>(wide_lambda, Q_prev, Q, K);
    for (int k = 1; k <= K; ++k) {
      Wide size = 0;
      for (const Wide c : coefficients[k - 1]) size = std::max(size, std::abs(c));
      for (std::size_t j = 0; j < coefficients[k - 1].size(); ++j)
        out.add(family::lax, indexed(family::lax, k, static_cast<long>(j)), coefficients[k - 1][j],
                size);
    }
  };
  observables.frame_defect = [n](const Eigen::MatrixXd& x) {
    return std::optional(orthogonality_defect(x.bottomRows(n)));
  };
  observables.speed = [=, h = scene.step()](const Eigen::MatrixXd& x) {
    return (x.bottomRows(n) - x.topRows(n)).norm() / std::abs(h);
  };
  return make_discrete_simulation(scene, DiscreteStiefel<double>(lambda, n), shared(observables));
}

}  // namespace

Simulations discrete_stiefel_simulations() { return {make_discrete_stiefel, keeps_all}; }

}  // namespace stiefel
