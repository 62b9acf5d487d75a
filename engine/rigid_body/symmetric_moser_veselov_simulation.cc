#include "engine/rigid_body/maps/symmetric_rigid_body_maps.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric_data.h"
#include "engine/stepping/make_simulation.h"
#include "engine/stepping/methods_on.h"

namespace stiefel {
namespace {

std::unique_ptr<Simulation> make_symmetric_moser_veselov(const Scene& scene) {
  const int N = scene.dimension();
  const double epsilon = scene.epsilon();
  StackedObservables observables = symmetric_observables(scene);
  observables.all_invariants = [=, lambda = scene.inertia(), h = scene.step(),
                                of_body = std::move(observables.all_invariants)](
                                   const Eigen::MatrixXd& x, InvariantList& out) {
    of_body(x, out);
    add_discrete_hamiltonian(lambda, Psi<double>(x.topRows(N), x.bottomRows(N), epsilon), h, out);
  };
  return make_simulation_by<Variational>(
      scene, SymmetricRigidBody<double>(scene.inertia(), epsilon), shared(observables));
}

}  // namespace

Simulations symmetric_moser_veselov_simulations() {
  return {make_symmetric_moser_veselov, keeps_all};
}

}  // namespace stiefel
