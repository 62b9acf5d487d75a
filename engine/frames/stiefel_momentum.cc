#include "engine/frames/body/stiefel_momenta.h"
#include "engine/frames/stiefel_forms.h"

namespace stiefel {
namespace {

/// Checks a scene of (Q, M). The simulation keeps M as its factors Q and P_0.
void check(SceneDraft& draft) {
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

WithinDomain<Expression> write(const Phase& x, const ConversionTarget&, Margins&) {
  const auto N = static_cast<double>(x.Q.cols());
  if (x.Q.cols() > largest_written_M) return outside({"N", N, largest_written_M}, "to");
  return Expression{{{"Q", x.Q}, {"M", dense_M(x.Q, S_of(x))}}};
}
/// Reads P_0, [ST] (82).
constexpr Representation representation = {false, read_costate, write};

constexpr auto start = [](const auto& g) { return start_of_costate(g, "Q", "P"); };

}  // namespace

SystemEntry stiefel_momentum_entry() {
  SystemInfo info = stiefel_info(
      {"M", "N x N", true, "momentum, skew: M = Q^T Q U Lambda + Lambda U Q^T Q, Q' = Q U"});
  info.name = "stiefel_momentum";
  info.summary = "geodesics on V(n, N) by the momentum M, held as factors Q and P_0";
  info.equations =
      "Q' = Q U, M' = [M, U] - A, A = [Q^T Q, U Lambda U], Q^T Q U Lambda + Lambda U Q^T Q = M";
  info.source = "[ST] (46)";
  info.file = "engine/frames/body/stiefel_costate.h";
  return {.info = info,
          .check = check,
          .recommended = for_costates,
          .representation = &representation,
          .motion = &in_both<frame_equations, start>,
          .rate = Rate::frame_speed};
}

}  // namespace stiefel
