#include "engine/rigid_body/symmetric_observables.h"

#include "engine/rigid_body/symmetric/symmetric_invariants.h"
#include "engine/rigid_body/symmetric/left_right.h"
#include "engine/rigid_body/symmetric/psi.h"

namespace stiefel {

StackedObservables symmetric_observables(const Scene& scene, Side side) {
  const int N = scene.dimension();
  const double epsilon = scene.epsilon();
  RigidForm form{
      .Q = [N](const auto& x) { return x.topRows(N).eval(); },
      .M = [=](const auto& x) { return Psi<double>(x.topRows(N), x.bottomRows(N), epsilon); },
      .side = side,
      .A = [N](const auto& x) { return constant_A<double>(x.topRows(N), x.bottomRows(N)); },
      .scaled = true,
      .terms = costate_terms(N, epsilon)};
  if (side == Side::right) {
    form.M = [=](const auto& x) {
      return Psi_right<double>(x.topRows(N), x.bottomRows(N), epsilon);
    };
    form.A = [N](const auto& x) -> Eigen::MatrixXd {
      return x.bottomRows(N).transpose() * x.topRows(N);
    };
  }
  StackedObservables observables(stacked(scene, "Q", "P"));
  observables.block("Q", 0, N).block("P", N, N);
  report_rigid_form(observables, scene, std::move(form));
  return observables;
}

}  // namespace stiefel
