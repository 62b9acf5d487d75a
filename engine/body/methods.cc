// The methods of methods.inc: their entries in the catalogue, and the rigid body moved by them. One
// file, because they use the same templates.
#include "engine/body/exact_body.h"
#include "engine/body/rigid_body.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_body_maps.h"
#include "engine/body/rigid_forms.h"
#include "engine/dense/so_4.h"
#include "engine/methods/all_methods.h"
#include "engine/motion/make_simulation.h"

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
  if constexpr (applies<Method, Body>)
    return make_simulation_by<Method>(
        scene, Body(rounded_to<typename Space::Scalar>(scene.inertia()), scene.has_frame()),
        rigid_body_observables(scene));
  else
    return nullptr;
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
  if constexpr (std::is_same_v<Method, Exact>) {
    if (scene.dimension() == 3) return exact_body(scene);
  } else {
    if constexpr (Method::traits.in_float)
      if (scene.in_float()) return body_in_coordinates<Method, So3, float>(scene);
    if (scene.dimension() == 3) return body_in_coordinates<Method, So3, double>(scene);
    if constexpr (Method::traits.in_so4)
      if (scene.dimension() == 4) return body_in_coordinates<Method, So4, double>(scene);
  }
  return body_in_space<Method, SoN<double>>(scene);
}

/// Returns what Method declares for bodies with states in Space.
template <class Method, class Space>
MethodOnSystem declared_for_bodies(const SystemInfo& info) {
  using Body = RigidBody<Space>;
  return declared_by(*method_entry(Method::traits.name), system_traits<Body>,
                     declared<Method, Body>, info);
}

}  // namespace

std::vector<MethodOnSystem> methods_of_rigid_bodies(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  for_each_type(Methods{}, [&]<class Method>(Method*) {
    if constexpr (applies<Method, RigidBody<SoN<double>>>) {
      all.push_back(declared_for_bodies<Method, SoN<double>>(info));
    } else if constexpr (applies<Method, RigidBody<So3<double, true>>>) {
      auto on = declared_for_bodies<Method, So3<double, true>>(info);
      on.where = "N = 3";
      on.takes = [](const Eigen::VectorXd& lambda) { return lambda.size() == 3; };
      all.push_back(on);
    }
  });
  return all;
}

std::unique_ptr<Simulation> make_rigid_body(const Scene& scene) {
  const std::string method = scene.method().empty() ? Variational::traits.name : scene.method();
  std::unique_ptr<Simulation> made;
  for_each_type(Methods{}, [&]<class Method>(Method*) {
    if (method == Method::traits.name) made = make_body<Method>(scene);
  });
  return made;
}

}  // namespace stiefel
