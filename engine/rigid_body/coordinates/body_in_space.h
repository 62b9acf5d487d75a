#pragma once

#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_body_observables.h"
#include "engine/stepping/make_simulation.h"
#include "engine/rigid_body/body/rigid_body.h"

namespace stiefel {

/// Returns the simulation by Method of the rigid body of a scene, with states in Space; null if the
/// method does not apply there.
template <class Method, class Space, class Observables>
std::unique_ptr<Simulation> body_in_space(const Scene& scene, const Observables& observables) {
  using Body = RigidBody<Space>;
  const double cost = rigid_body_cost(scene.dimension());
  const auto body = [&] { return Body(rounded_to<typename Space::Scalar>(scene.inertia())); };
  if constexpr (!applies<Method, Body>)
    return nullptr;
  else if constexpr (has_map_for<Method, Body> || !HasMatrixStates<Body>)
    return make_simulation_by<Method>(scene, body(), observables, cost);
  else
    return make_matrix_simulation(*method_entry(Method::traits.name), scene, body(), observables,
                                  cost);
}

}  // namespace stiefel
