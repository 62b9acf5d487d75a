#include <cmath>

#include "engine/rigid_body/moser_veselov/discrete_pairs.h"
#include "engine/rigid_body/moser_veselov/moser_veselov_pair.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_moser_veselov_pair(const Scene& scene) {
  const int N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  const double h = scene.step();
  StackedObservables observables(stacked(scene, "Q_prev", "Q"));
  observables.block("Q_prev", 0, N).block("Q", N, N);
  report_rigid_form(
      observables, scene,
      {.Q = [N](const auto& x) { return x.bottomRows(N).eval(); },
       .M =
           [=](const auto& x) { return Sigma_L<double>(lambda, x.topRows(N), x.bottomRows(N), h); },
       .terms = [terms = lambda.stableNorm() / std::abs(h)](const auto&) { return terms; }});
  observables.all_invariants = [=, of_body = std::move(observables.all_invariants)](
                                   const Eigen::MatrixXd& x, InvariantList& out) {
    of_body(x, out);
    add_discrete_hamiltonian(lambda, Sigma_L<double>(lambda, x.topRows(N), x.bottomRows(N), h), h,
                             out);
  };
  return make_discrete_simulation(scene, MoserVeselovPair<double>(lambda, h), shared(observables));
}

}  // namespace

Simulations moser_veselov_pair_simulations() { return {make_moser_veselov_pair, keeps_all}; }

}  // namespace stiefel
