#include "engine/rigid_body/moser_veselov/moser_veselov.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_body_observables.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

template <class Space, class... MovesFrame>
std::unique_ptr<Simulation> make_in(const Scene& scene, MovesFrame... moves_frame) {
  const MoserVeselov<Space> map(scene.inertia(), scene.step(), Arithmetic::compensated,
                                moves_frame...);
  return make_discrete_simulation(scene, map, rigid_body_observables(scene),
                                  rigid_body_cost(scene.dimension()));
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  if (scene.dimension() == 3) return make_in<So3<double, true>>(scene, scene.has_frame());
  if (scene.dimension() == 4) return make_in<So4<double, true>>(scene, scene.has_frame());
  return make_in<SoN<double>>(scene);
}

}  // namespace

Simulations moser_veselov_simulations() { return {make, keeps_all}; }

}  // namespace stiefel
