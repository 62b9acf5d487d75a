#pragma once

#include "engine/body/rigid_body.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_body_observables.h"
#include "engine/motion/make_simulation.h"

namespace stiefel {

/// Returns the simulation of a rigid body, with matrices as states, by a general method.
std::unique_ptr<Simulation> body_in_matrices(const MethodEntry& method, const Scene& scene);

/// Returns the simulation by Method of the rigid body of a scene, with states in Space; null if the
/// method does not apply there.
template <class Method, class Space>
std::unique_ptr<Simulation> body_in_space(const Scene& scene) {
  using Body = RigidBody<Space>;
  using Scalar = typename Space::Scalar;
  if constexpr (!applies<Method, Body>)
    return nullptr;
  else if constexpr (has_map_for<Method, Body> || !HasMatrixStates<Body>)
    return make_simulation_by<Method>(scene,
                                      Body(rounded_to<Scalar>(scene.inertia()), scene.has_frame()),
                                      rigid_body_observables(scene));
  else
    return body_in_matrices(*method_entry(Method::traits.name), scene);
}

/// Returns the simulation by Method with states in Space<Scalar, frame>, which hold Q, or zeros
/// where the scene has none. A method for which M alone is much cheaper
/// (MethodTraits::momentum_alone) then has states without it.
template <class Method, template <class, bool> class Space, class Scalar>
std::unique_ptr<Simulation> body_in_coordinates(const Scene& scene) {
  if constexpr (Method::traits.momentum_alone)
    if (!scene.has_frame()) return body_in_space<Method, Space<Scalar, false>>(scene);
  return body_in_space<Method, Space<Scalar, true>>(scene);
}

}  // namespace stiefel
