#include "engine/catalogue/system_entry.h"
#include "engine/rigid_body/coordinates/body_by_method.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_rigid_body(const Scene& scene) {
  return is_exact_body(scene) ? exact_body(scene) : make_body_simulation(scene);
}

/// Returns the methods that move rigid bodies.
std::vector<MethodOnSystem> methods(const SystemInfo& info) {
  std::vector<MethodOnSystem> all;
  for (const BodyByMethod& body : bodies_by_methods()) all.push_back(body.declared(info));
  return all;
}

}  // namespace

Simulations rigid_body_simulations() { return {make_rigid_body, methods}; }

}  // namespace stiefel
