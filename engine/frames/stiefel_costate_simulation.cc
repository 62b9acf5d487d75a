#include "engine/frames/body/stiefel_costate.h"
#include "engine/frames/body/stiefel_invariants.h"
#include "engine/frames/stiefel_forms.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene, bool with_M) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  const int rows = static_cast<int>(n), columns = static_cast<int>(N);
  const StackedObservables::Value M = [n](const auto& x, auto out) {
    out = dense_M<double>(x.topRows(n), x.bottomRows(n));
  };
  StackedObservables observables(stacked(scene, "Q", "P"));
  observables.block("Q", 0, rows);
  if (with_M)
    observables.computed_block({"M", columns, columns}, M);
  else
    observables.block("P", rows, rows);
  report_geodesic(
      observables, scene, n,
      [=](const Eigen::MatrixXd& x) {
        return Legendre_inverse<double>(lambda, x.topRows(n), x.bottomRows(n));
      },
      terms_of_S(scene, n, true));
  if (!with_M && N <= largest_written_M) observables.field({"M", columns, columns}, M);
  const auto of_S = std::move(observables.all_invariants);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    of_S(x, out);
    if (with_M || !out.wants(family::PQt)) return;
    const Eigen::MatrixXd A = costate_product<double>(x.topRows(n), x.bottomRows(n));
    const double scale = x.bottomRows(n).norm();
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        out.add(family::PQt, indexed(family::PQt, i, j), A(i, j), scale);
  };
  return make_simulation(scene, StiefelCostate<double>(lambda, n), shared(observables));
}

}  // namespace

Simulations stiefel_costate_simulations() {
  return {[](const Scene& scene) { return make(scene, false); },
          methods_on<StiefelCostate<double>>};
}
/// Their state is that of the costate, P_0.
Simulations stiefel_momentum_simulations() {
  return {[](const Scene& scene) { return make(scene, true); }, methods_on<StiefelCostate<double>>};
}

}  // namespace stiefel
