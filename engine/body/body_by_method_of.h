#pragma once

#include "engine/body/body_by_method.h"
#include "engine/body/body_in_space.h"
#include "engine/body/rigid_body_maps.h"
#include "engine/dense/so_4.h"
#include "engine/motion/methods_on.h"

namespace stiefel {

/// Returns the simulation of a rigid body by Method.
template <class Method>
std::unique_ptr<Simulation> make_body(const Scene& scene) {
  if constexpr (Method::traits.in_float)
    if (scene.in_float()) return body_in_coordinates<Method, So3, float>(scene);
  if (scene.dimension() == 3) return body_in_coordinates<Method, So3, double>(scene);
  if constexpr (Method::traits.in_so4)
    if (scene.dimension() == 4) return body_in_coordinates<Method, So4, double>(scene);
  return body_in_space<Method, SoN<double>>(scene);
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
    return BodyByMethod{Method::traits.name, declared_for_bodies<Method>, make_body<Method>};
  } else {
    return std::nullopt;
  }
}

}  // namespace stiefel
