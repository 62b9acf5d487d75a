#include "engine/rigid_body/coordinates/moser_veselov_4d.h"

#include "engine/rigid_body/moser_veselov/moser_veselov.h"
#include "engine/rigid_body/coordinates/so4_observables.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/stepping/make_simulation.h"

namespace stiefel {
namespace {

template <bool frame>
std::unique_ptr<Simulation> discrete_body(const Scene& scene) {
  using Map = MoserVeselov<So4<double, frame>, Arithmetic::compensated>;
  return make_discrete_simulation(scene, Map(scene.inertia(), scene.step()),
                                  so4_observables<double, frame>(scene), rigid_body_cost(4));
}

}  // namespace

std::unique_ptr<Simulation> moser_veselov_4d(const Scene& scene) {
  return scene.has_frame() ? discrete_body<true>(scene) : discrete_body<false>(scene);
}

}  // namespace stiefel
