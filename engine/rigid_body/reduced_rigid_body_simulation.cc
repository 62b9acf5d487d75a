#include <cmath>

#include "engine/rigid_body/maps/turned_bodies.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/rigid_body/symmetric/symmetric_invariants.h"
#include "engine/stepping/methods_on.h"
#include "engine/stepping/shared_maps.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_reduced_rigid_body(const Scene& scene) {
  const int N = scene.dimension();
  const double epsilon = scene.epsilon();
  const Eigen::MatrixXd A = constant_A<double>(scene.Q(), scene.block("P"));
  StackedObservables observables(scene.Q());
  observables.block("Q", 0, N);
  observables.computed_block({"P", N, N}, [A](const auto& Q, auto out) { out = A * Q; });
  report_rigid_form(
      observables, scene,
      {.Q = [](const auto& Q) { return Q; },
       .M = [=](const auto& Q) -> Eigen::MatrixXd {
         return Q.transpose() * (A - A.transpose()) * Q / epsilon;
       },
       .scaled = true,
       .terms = [terms = A.stableNorm() / std::abs(epsilon)](const auto&) { return terms; }});
  return make_simulation(scene, ReducedRigidBody<double>(scene.inertia(), A, epsilon),
                         shared(observables));
}

}  // namespace

Simulations reduced_rigid_body_simulations() {
  return {make_reduced_rigid_body, methods_on<ReducedRigidBody<double>>};
}

}  // namespace stiefel
