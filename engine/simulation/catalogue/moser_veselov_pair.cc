#include "engine/maps/moser_veselov_pair.h"
#include "engine/simulation/stepping/invariant_list.h"

#include <cmath>

#include "engine/representations/discrete_pairs.h"
#include "engine/simulation/catalogue/families/discrete_hamiltonian.h"
#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/rigid_body_data.h"
#include "engine/simulation/catalogue/families/rigid_body_scene.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

using Map = MoserVeselovPair<double>;

void check(SceneDraft& draft) {
  check_no_extras(draft);
  draft.refuse_if(draft.given().body.has_value(), "body");
  if (!draft.set_inertia()) return;
  draft.check_inertia_sums();
  draft.check_block_names();
  const Eigen::Index N = draft.scene().dimension();
  for (const char* name : {"Q_prev", "Q"})
    if (const RowMatrix* Q = draft.block(name, N, N)) draft.set_frame(name, *Q);
}

std::unique_ptr<Simulation> make(const Scene& scene) {
  const int N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  const double h = scene.step();
  StackedObservables observables(stacked(scene, "Q_prev", "Q"));
  observables.block("Q_prev", 0, N).block("Q", N, N);
  report_rigid_form(
      observables, scene,
      {.Q = [N](const auto& x) { return x.bottomRows(N).eval(); },
       .M =
           [=](const auto& x) { return Sigma_L<double>(lambda, x.topRows(N), x.bottomRows(N), h); },
       .terms = [terms = lambda.stableNorm() / std::abs(h)](const auto&) { return terms; }});
  observables.all_invariants = [=, of_body = std::move(observables.all_invariants)](
                               const Eigen::MatrixXd& x, InvariantList& out) {
    of_body(x, out);
    add_discrete_hamiltonian(lambda, Sigma_L<double>(lambda, x.topRows(N), x.bottomRows(N), h), h,
                             out);
  };
  return make_discrete_simulation(scene, Map(lambda, h), shared(observables), rigid_body_cost(N));
}

}  // namespace

SystemEntry moser_veselov_pair_entry() {
  SystemInfo info = rigid_form_info({"M", "N x N", false, ""}, false);
  info.blocks = {{"Q_prev", "N x N", true, "frame one step before"},
                 {"Q", "N x N", true, "frame, orthogonal"}};
  info.fields = {{"Q_prev", "N x N", "frame one step before"},
                 {"Q", "N x N", "frame, orthogonal"},
                 {"M", "N x N", "body momentum, M = (Lambda U - U^T Lambda) / h, U = Q_prev^T Q"},
                 {"Omega", "N x N", "J^-1(M): Omega_ij = M_ij / (lambda_i + lambda_j)"}};
  info.name = "moser_veselov_pair";
  info.summary = "discrete rigid body of Moser and Veselov on pairs of frames";
  info.equations =
      "h M_k = Lambda V - V^T Lambda, V = Q_{k-1}^T Q_k, U Lambda - Lambda U^T = h M_k, "
      "Q_{k+1} = Q_k U";
  info.source = "[RB] (4.4)";
  info.file = "engine/maps/moser_veselov_pair.h";
  info.discrete = true;
  info.invariants.push_back(discrete_hamiltonian_info);
  info.methods = keeps_all(info);
  return {.info = info,
          .check = check,
          .make = make,
          .two_forms = {&two_form::of_two_frames},
          .representation = &representation::two_frames,
          .motion = &motion_start::two_frames,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
