#include "engine/catalogue/two_form.h"
#include "engine/frames/stiefel_forms.h"
#include "engine/laws/tangent_spaces.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

void check(SceneDraft& draft) {
  if (!check_stiefel_frame(draft)) return;
  const auto& Q = draft.scene().Q();
  if (const RowMatrix* P = draft.block("P", Q.rows(), Q.cols())) set_costate(draft, "P", *P);
}

/// Writes P_0 by 𝔐, [ST] Prop. 6.
WithinDomain<Expression> write(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q}, {"P", Legendre(x.Q, S_of(x))}}};
}
constexpr Representation representation = {false, read_costate, write};

constexpr auto start = [](const auto& g) { return start_of_costate(g, "Q", "P"); };

constexpr TwoForm form_of_pairs = {
    {"omega_pairs",
     {"Q", "P"},
     "tr(u_1^T v_2) - tr(u_2^T v_1) of u = (u_1, u_2), v = (v_1, v_2)",
     "[ST] (63), (71)"},
    {"Q", "P"},
    [](const Scene&) { return space_of(CostatesOfFrames<double>()); }};

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
  info.file = "engine/frames/body/stiefel_costate.h";
  return {.info = info,
          .check = check,
          .recommended = for_costates,
          .two_forms = {&form_of_pairs},
          .representation = &representation,
          .motion = &in_both<frame_equations, start>,
          .rate = Rate::frame_speed};
}

}  // namespace stiefel
