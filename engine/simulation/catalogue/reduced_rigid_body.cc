#include "engine/methods/special/turned_bodies.h"

#include <cmath>

#include "engine/invariants/symmetric_rigid_body.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/families/symmetric_scene.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make(const Scene& scene) {
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
  return make_simulation(scene, ReducedRigidBody<double>(scene.inertia(), A, epsilon), shared(observables),
                         rigid_body_cost(N));
}

}  // namespace

SystemEntry reduced_rigid_body_entry() {
  SystemInfo info = rigid_form_info(costate_block(), true);
  info.name = "reduced_rigid_body";
  info.summary = "symmetric representation with its constant P Q^T taken out";
  info.equations = "Q' = Q J^-1(Q^T (A - A^T) Q) / epsilon, A = P Q^T constant, P = A Q";
  info.source = "[RB] (8.2)";
  info.file = "engine/systems/reduced_rigid_body.h";
  // The system holds PQᵀ as a constant, so that its drift is 0 by construction.
  std::erase_if(info.invariants, [](const auto& i) { return i.name == family::PQt; });
  info.methods = methods_on<ReducedRigidBody<double>>(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_symmetric(draft, false); },
          .make = make,
          .recommended = for_products,
          .representation = &representation::symmetric_body,
          .motion = &motion_start::reduced_body,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
