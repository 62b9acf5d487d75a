#include <algorithm>

#include "engine/body/body_by_method.h"
#include "engine/body/body_in_space.h"
#include "engine/methods/variational.h"

namespace stiefel {

#define METHOD(file, Type) std::optional<BodyByMethod> body_by_##file();
#include "engine/methods/methods.inc"
#undef METHOD

const std::vector<BodyByMethod>& bodies_by_methods() {
  static const std::vector<BodyByMethod> all = [] {
    std::vector<BodyByMethod> made;
    for (const auto& body : {
#define METHOD(file, Type) body_by_##file(),
#include "engine/methods/methods.inc"
#undef METHOD
         })
      if (body) made.push_back(*body);
    return made;
  }();
  return all;
}

std::unique_ptr<Simulation> body_in_matrices(const MethodEntry& method, const Scene& scene) {
  return make_matrix_simulation(method, scene, RigidBody<SoN<double>>(scene.inertia()),
                                rigid_body_observables(scene));
}

std::unique_ptr<Simulation> make_body_simulation(const Scene& scene) {
  const auto& all = bodies_by_methods();
  const std::string method = scene.method().empty() ? Variational::traits.name : scene.method();
  const auto body = std::ranges::find(all, method, &BodyByMethod::method);
  return body == all.end() ? nullptr : body->make(scene);
}

}  // namespace stiefel
