// The methods of methods.inc: their entries in the catalogue, and the rigid body moved by them. One
// file, because they use the same templates.
#include <algorithm>

#include "engine/body/body_by_method.h"
#include "engine/body/rigid_body.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_body_maps.h"
#include "engine/body/rigid_body_observables.h"
#include "engine/dense/so_4.h"
#include "engine/methods/all_methods.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/method_entry_of.h"
#include "engine/motion/methods_on.h"

namespace stiefel {

#define METHOD(file, Type) \
  MethodEntry file##_method() { return method_entry_of<Type>(); }
#include "engine/methods/methods.inc"
#undef METHOD

namespace {

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
    return make_matrix_simulation(*method_entry(Method::traits.name), scene, Body(scene.inertia()),
                                  rigid_body_observables(scene));
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

}  // namespace

const std::vector<BodyByMethod>& bodies_by_methods() {
  static const std::vector<BodyByMethod> all = [] {
    std::vector<BodyByMethod> made;
    for_each_type(Methods{}, [&]<class Method>(Method*) {
      if constexpr (applies<Method, RigidBody<SoN<double>>> ||
                    applies<Method, RigidBody<So3<double, true>>>)
        made.push_back({Method::traits.name, declared_for_bodies<Method>, make_body<Method>});
    });
    return made;
  }();
  return all;
}

std::unique_ptr<Simulation> make_body_simulation(const Scene& scene) {
  const auto& all = bodies_by_methods();
  const std::string method = scene.method().empty() ? Variational::traits.name : scene.method();
  const auto body = std::ranges::find(all, method, &BodyByMethod::method);
  return body == all.end() ? nullptr : body->make(scene);
}

}  // namespace stiefel
