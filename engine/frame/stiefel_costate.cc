// Geodesics on V(n, N) by costates: P, or the momentum M held as its factors Q and P_0.
#include "engine/frame/stiefel_costate.h"
#include "engine/frame/stiefel_forms.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/two_form.h"
#include "engine/structure/tangent_spaces.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

void check_costate(SceneDraft& draft) {
  if (!check_stiefel_frame(draft)) return;
  const auto& Q = draft.scene().Q();
  if (const RowMatrix* P = draft.block("P", Q.rows(), Q.cols())) set_costate(draft, "P", *P);
}

/// Writes P_0 by 𝔐, [ST] Prop. 6.
WithinDomain<FormBlocks> write_costate(const Phase& x, const ConversionTarget&, Margins&) {
  return FormBlocks{{{"Q", x.Q}, {"P", Legendre(x.Q, S_of(x))}}};
}
constexpr Representation costate_representation = {false, read_costate, write_costate};

constexpr auto costate_start = [](const auto& g) { return start_of_costate(g, "Q", "P"); };

constexpr TwoForm form_of_costates = {
    {"omega_pairs",
     {"Q", "P"},
     "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)",
     "[ST] (63), (71)"},
    {"Q", "P"},
    [](const Scene&) { return space_of(CostatesOfFrames<double>()); }};

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

WithinDomain<FormBlocks> write_momentum(const Phase& x, const ConversionTarget&, Margins&) {
  const auto N = static_cast<double>(x.Q.cols());
  if (x.Q.cols() > largest_written_M) return outside({"N", N, largest_written_M}, "to");
  return FormBlocks{{{"Q", x.Q}, {"M", dense_M(x.Q, S_of(x))}}};
}
/// Reads P_0, [ST] (82).
constexpr Representation momentum_representation = {false, read_costate, write_momentum};

/// `with_M`: reports M in place of P.
std::unique_ptr<Simulation> make_of_costates(const Scene& scene, bool with_M) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  const int rows = static_cast<int>(n), columns = static_cast<int>(N);
  const Observables::Value M = [n](const auto& x, auto out) {
    out = dense_M<double>(x.topRows(n), x.bottomRows(n));
  };
  Observables observables(stacked(scene, "Q", "P"));
  observables.block("Q", 0, rows);
  if (with_M)
    observables.computed_block({"M", columns, columns}, M);
  else
    observables.block("P", rows, rows);
  report_geodesic(observables, {scene.inertia(), n, true});
  if (!with_M && N <= largest_written_M) observables.field({"M", columns, columns}, M);
  const auto of_S = std::move(observables.all_invariants);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    of_S(x, out);
    if (with_M || !out.wants(family::PQt)) return;
    const Eigen::MatrixXd A = x.bottomRows(n) * x.topRows(n).transpose();
    out.add_elements(family::PQt, A, x.bottomRows(n).norm());
  };
  return make_simulation(scene, StiefelCostate<double>(scene.inertia(), n), shared(observables));
}

template <bool with_M>
SystemEntry entry_of_costates(SystemInfo info) {
  info.file = "engine/frame/stiefel_costate.h";
  return {.info = std::move(info),
          .check = with_M ? check_momentum : check_costate,
          .make = [](const Scene& scene) { return make_of_costates(scene, with_M); },
          .methods = methods_on<StiefelCostate<double>>,
          .recommended = for_costates,
          .representation = with_M ? &momentum_representation : &costate_representation,
          .motion = &in_both<frame_equations, costate_start>,
          .rate = Rate::frame_speed};
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
  SystemEntry made = entry_of_costates<false>(std::move(info));
  made.two_forms = {&form_of_costates};
  return made;
}

SystemEntry stiefel_momentum_entry() {
  SystemInfo info = stiefel_info(
      {"M", "N x N", true, "momentum, skew: M = Q^T Q U Lambda + Lambda U Q^T Q, Q' = Q U"});
  info.name = "stiefel_momentum";
  info.summary = "geodesics on V(n, N) by the momentum M, held as factors Q and P_0";
  info.equations =
      "Q' = Q U, M' = [M, U] - A, A = [Q^T Q, U Lambda U], Q^T Q U Lambda + Lambda U Q^T Q = M";
  info.source = "[ST] (46)";
  return entry_of_costates<true>(std::move(info));
}

}  // namespace stiefel
