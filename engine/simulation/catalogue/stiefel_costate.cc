#include "engine/systems/stiefel_costate.h"
#include "engine/simulation/stepping/invariant_list.h"

#include "engine/invariants/stiefel.h"
#include "engine/representations/stiefel_legendre.h"
#include "engine/representations/stiefel_momenta.h"
#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/families/stiefel_forms.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

constexpr Eigen::Index largest_written_M = 4096;

std::unique_ptr<Simulation> make(const Scene& scene, const Eigen::MatrixXd& start, bool with_M) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  const int rows = static_cast<int>(n), columns = static_cast<int>(N);
  const StackedObservables::Value M = [n](const auto& x, auto out) {
    out = dense_M<double>(x.topRows(n), x.bottomRows(n));
  };
  StackedObservables observables(start);
  observables.block("Q", 0, rows);
  if (with_M)
    observables.computed_block({"M", columns, columns}, M);
  else
    observables.block("P", rows, rows);
  report_geodesic(
      observables, scene, n,
      [=](const Eigen::MatrixXd& x) {
        return Legendre_inverse<double>(lambda, x.topRows(n), x.bottomRows(n));
      },
      terms_of_S(scene, n, true));
  if (!with_M && N <= largest_written_M) observables.field({"M", columns, columns}, M);
  const auto of_S = std::move(observables.all_invariants);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    of_S(x, out);
    if (with_M || !out.wants(family::PQt)) return;
    const Eigen::MatrixXd A = costate_product<double>(x.topRows(n), x.bottomRows(n));
    const double scale = x.bottomRows(n).norm();
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        out.add(family::PQt, indexed(family::PQt, i + 1, j + 1), A(i, j), scale);
  };
  return make_simulation(scene, StiefelCostate<double>(lambda, n), shared(observables),
                         3 * stiefel_cost(n, N));
}

void check_costate(SceneDraft& draft) {
  if (!check_stiefel_frame(draft)) return;
  const auto& Q = draft.scene().Q();
  if (const RowMatrix* P = draft.block("P", Q.rows(), Q.cols())) set_costate(draft, "P", *P);
}

/// Checks a scene of (Q, M). The simulation keeps M as its factors Q and P_0.
void check_momentum(SceneDraft& draft) {
  if (!check_stiefel_frame(draft)) return;
  const auto& Q = draft.scene().Q();
  if (Q.cols() > largest_written_M)
    return draft.refuse("inertia", std::to_string(Q.cols()) + " numbers",
                        "must have at most 4096 numbers, because M is an N x N block; for larger N "
                        "use stiefel_costate with the block P");
  const RowMatrix* given = draft.block("M", Q.cols(), Q.cols());
  if (given == nullptr) return;
  draft.set_skew("M", *given);
  if (!draft.sound()) return;
  const auto P_0 = P_0_of_M<double>(Q, draft.scene().M());
  if (!P_0)
    return draft.refuse("initial.M", "max |(I − QᵀQ)M(I − QᵀQ)| = " + to_text(P_0.error().value),
                        "must be of the form QᵀP − PᵀQ");
  draft.set_block("P", *P_0);
}

}  // namespace

SystemEntry stiefel_costate_entry() {
  SystemInfo info = stiefel_info(
      {"P", "n x N", true,
       "costate, any with Q^T P - P^T Q = M = Q^T Q U Lambda + Lambda U Q^T Q, Q' = Q U"});
  info.fields.push_back({"M", "N x N", "M = Q^T P - P^T Q, N <= 4096"});
  info.invariants.push_back(
      {family::PQt, "P Q^T = (k + m) / 2, k = P Q^T + Q P^T, m = P Q^T - Q P^T", "[ST] (76)"});
  info.name = "stiefel_costate";
  info.summary = "geodesics on V(n, N) as optimal control; P = P_0: generalised McLachlan-Scovel";
  info.equations =
      "Q' = Q U, P' = P U - Q A, A = [Q^T Q, U Lambda U], Q^T Q U Lambda + Lambda U Q^T Q = M";
  info.source = "[ST] (68)-(69)";
  info.file = "engine/systems/stiefel_costate.h";
  info.methods = methods_on<StiefelCostate<double>>(info);
  return {.info = info,
          .check = check_costate,
          .make = [](const Scene& scene) { return make(scene, stacked(scene, "Q", "P"), false); },
          .recommended = for_costates,
          .two_forms = {&two_form::of_costate_pairs},
          .representation = &representation::costate,
          .motion = &motion_start::costate,
          .rate = Rate::frame_speed};
}

SystemEntry stiefel_momentum_entry() {
  SystemInfo info = stiefel_info(
      {"M", "N x N", true, "momentum, skew: M = Q^T Q U Lambda + Lambda U Q^T Q, Q' = Q U"});
  info.name = "stiefel_momentum";
  info.summary = "geodesics on V(n, N) by the momentum M, held as factors Q and P_0";
  info.equations =
      "Q' = Q U, M' = [M, U] - A, A = [Q^T Q, U Lambda U], Q^T Q U Lambda + Lambda U Q^T Q = M";
  info.source = "[ST] (46)";
  info.file = "engine/systems/stiefel_costate.h";
  info.methods = methods_on<StiefelCostate<double>>(info);
  return {.info = info,
          .check = check_momentum,
          .make = [](const Scene& scene) { return make(scene, stacked(scene, "Q", "P"), true); },
          .recommended = for_costates,
          .representation = &representation::momentum,
          .motion = &motion_start::costate,
          .rate = Rate::frame_speed};
}

}  // namespace stiefel
