#include "engine/maps/symmetric_moser_veselov.h"
#include "engine/simulation/stepping/invariant_list.h"

#include "engine/representations/psi.h"
#include "engine/simulation/catalogue/families/discrete_hamiltonian.h"
#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/families/symmetric_observables.h"
#include "engine/simulation/catalogue/families/symmetric_scene.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

using Map = SymmetricMoserVeselov<double>;

std::unique_ptr<Simulation> make(const Scene& scene) {
  const int N = scene.dimension();
  const double epsilon = scene.epsilon();
  StackedObservables observables = symmetric_observables(scene);
  observables.all_invariants = [=, lambda = scene.inertia(), h = scene.step(),
                            of_body = std::move(observables.all_invariants)](const Eigen::MatrixXd& x,
                                                                         InvariantList& out) {
    of_body(x, out);
    add_discrete_hamiltonian(lambda, Psi<double>(x.topRows(N), x.bottomRows(N), epsilon), h, out);
  };
  return make_discrete_simulation(scene, Map(scene.inertia(), scene.step(), epsilon), shared(observables),
                                  rigid_body_cost(N));
}

}  // namespace

SystemEntry symmetric_moser_veselov_entry() {
  SystemInfo info = rigid_form_info(costate_block(), true);
  info.name = "symmetric_moser_veselov";
  info.summary = "symmetric representation of the discrete rigid body";
  info.equations = "U Lambda - Lambda U^T = h M_k, Q_{k+1} = Q_k U, P_{k+1} = P_k U";
  info.source = "[RB] (4.7)";
  info.file = "engine/maps/symmetric_moser_veselov.h";
  info.discrete = true;
  info.invariants.push_back(discrete_hamiltonian_info);
  info.methods = keeps_all(info);
  return {.info = info,
          .check = [](SceneDraft& draft) { check_symmetric(draft, false, draft.step()); },
          .make = make,
          .two_forms = {&two_form::of_symmetric_pairs},
          .dirac_bracket = true,
          .representation = &representation::symmetric_body,
          .motion = &motion_start::symmetric_body,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
