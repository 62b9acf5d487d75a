#pragma once

#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/coordinates/body_by_method.h"
#include "engine/rigid_body/coordinates/body_in_space.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {

/// Returns the simulation of a rigid body by Method in double precision.
template <class Method>
std::unique_ptr<Simulation> body_in_double(const Scene& scene) {
  const auto in_space = [&]<class Space>(Space*) {
    return body_in_space<Method, Space>(scene, RigidBodyObservables<Space>(scene));
  };
  if (scene.dimension() != 3) return in_space(static_cast<SoN<double>*>(nullptr));
  if (scene.has_frame()) return in_space(static_cast<So3<double, true>*>(nullptr));
  return in_space(static_cast<So3<double, false>*>(nullptr));
}

/// Returns what Method declares for rigid bodies: those of every dimension, or of three alone.
template <class Method>
MethodOnSystem declared_for_bodies(const SystemInfo& info) {
  if constexpr (applies<Method, RigidBody<SoN<double>>>) {
    return declared_by<Method, RigidBody<SoN<double>>>(info);
  } else {
    auto on = declared_by<Method, RigidBody<So3<double, true>>>(info);
    on.where = "N = 3";
    on.takes = [](const Eigen::VectorXd& lambda) { return lambda.size() == 3; };
    return on;
  }
}

/// Returns nullopt if Method does not move rigid bodies.
template <class Method>
std::optional<BodyByMethod> body_by_method_of() {
  if constexpr (applies<Method, RigidBody<SoN<double>>> ||
                applies<Method, RigidBody<So3<double, true>>>) {
    BodyByMethod body{Method::traits.name, declared_for_bodies<Method>, body_in_double<Method>};
    if constexpr (Method::traits.in_float) body.in_float = body_in_float<Method>;
    if constexpr (Method::traits.in_so4) body.in_so4 = body_in_so4<Method>;
    return body;
  } else {
    return std::nullopt;
  }
}

}  // namespace stiefel
