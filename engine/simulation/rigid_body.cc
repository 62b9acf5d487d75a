#include "engine/systems/rigid_body.h"

#include "engine/simulation/methods.h"
#include "engine/simulation/rigid_body_data.h"
#include "engine/simulation/simulation_of.h"
#include "engine/simulation/system_entry.h"

namespace stiefel {
namespace {

using Made = std::unique_ptr<Simulation>;

template <class Method, class Space, Arithmetic arithmetic>
Made make_with(const Scene& scene) {
  using Map = typename Method::template Map<RigidBody<Space>, arithmetic>;
  using Readout = RigidBodyReadout<Space>;
  const double h = scene.step() / scene.substeps(), N = scene.dimension();
  const double cost = N == 3 ? 300 : 1000 + 50 * N * N + 5 * N * N * N;
  return std::make_unique<SimulationOf<Map, Readout>>(
      scene, Map(RigidBody<Space>(scene.inertia()), h, scene.order()), Readout(scene), cost);
}

template <class Method, Arithmetic arithmetic>
Made make_in_space(const Scene& scene) {
  if (scene.dimension() != 3) return make_with<Method, SoN<double>, arithmetic>(scene);
  if (scene.has_frame()) return make_with<Method, So3<double, true>, arithmetic>(scene);
  return make_with<Method, So3<double, false>, arithmetic>(scene);
}

template <class... M>
Made make_by_method(const Scene& scene, TypeList<M...>) {
  Made made;
  const auto attempt = [&]<class Method>(Method*) {
    if (scene.method() != Method::traits.name) return;
    made = scene.arithmetic() == Arithmetic::plain
               ? make_in_space<Method, Arithmetic::plain>(scene)
               : make_in_space<Method, Arithmetic::compensated>(scene);
  };
  (attempt(static_cast<M*>(nullptr)), ...);
  return made;
}

template <class... M>
std::vector<MethodOnSystem> methods(TypeList<M...>) {
  return {{M::traits.name, preservations([](auto invariant) { return M::kept(invariant); })}...};
}

}  // namespace

SystemEntry rigid_body_entry() {
  SystemInfo info = rigid_body_family();
  info.name = "rigid_body";
  info.summary = "free rigid body in N dimensions";
  info.equations = "Q' = Q Omega, M' = [M, Omega], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (2.2), (2.3)";
  info.file = "engine/systems/rigid_body.h";
  info.discrete = false;
  info.methods = methods(Methods{});
  return {info, [](const Scene& scene) { return make_by_method(scene, Methods{}); }};
}

}  // namespace stiefel
