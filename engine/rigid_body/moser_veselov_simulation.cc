#include "engine/rigid_body/coordinates/so4_observables.h"
#include "engine/rigid_body/moser_veselov/moser_veselov.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

template <class Space>
std::unique_ptr<Simulation> make_in(const Scene& scene, const auto& observables) {
  using Map = MoserVeselov<Space, Arithmetic::compensated>;
  return make_discrete_simulation(scene, Map(scene.inertia(), scene.step()), observables,
                                  rigid_body_cost(scene.dimension()));
}

template <bool frame>
std::unique_ptr<Simulation> make_small(const Scene& scene) {
  using InSpace = So3<double, frame>;
  if (scene.dimension() == 3) return make_in<InSpace>(scene, RigidBodyObservables<InSpace>(scene));
  return make_in<So4<double, frame>>(scene, so4_observables<double, frame>(scene));
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (scene.dimension() == 3 || scene.dimension() == 4)
    return scene.has_frame() ? make_small<true>(scene) : make_small<false>(scene);
  return make_in<SoN<double>>(scene, RigidBodyObservables<SoN<double>>(scene));
}

}  // namespace

Simulations moser_veselov_simulations() { return {make, keeps_all}; }

}  // namespace stiefel
