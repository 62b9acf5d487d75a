#include "engine/catalogue/representation.h"
#include "engine/catalogue/series_start.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"

namespace stiefel {
namespace {

// The motion is that of the left-invariant body with Qᵀ and −M, [RB] Prop. 2.1.

WithinDomain<Phase> read(const Scene& scene, Margins&) {
  return phase_of_body(scene, scene.Q().transpose(), -scene.M());
}
WithinDomain<Expression> write(const Phase& x, const ConversionTarget&, Margins&) {
  return Expression{{{"Q", x.Q.transpose()}, {"M", -x.M}}};
}
constexpr Representation representation = {true, read, write};

constexpr auto start = [](const auto& g) {
  auto of_left = g.body(g.block("Q").transpose(), -g.block("M"));
  of_left.presentation.right = true;
  return of_left;
};

constexpr std::array recommendations = {closed_form_of_body, with_error_control(1e-12, 0.15)};

}  // namespace

SystemEntry right_rigid_body_entry() {
  SystemInfo info = rigid_form_info({"M", "N x N", true, "momentum, skew"}, false, Side::right);
  info.name = "right_rigid_body";
  info.summary = "free rigid body in N dimensions, right-invariant";
  info.equations = "Q' = Omega Q, M' = [Omega, M], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (RightRBn), Prop. 2.1";
  info.file = "engine/rigid_body/body/right_rigid_body.h";
  return {.info = info,
          .check = [](SceneDraft& draft) { check_rigid_body(draft, true); },
          .recommended = recommendations,
          .representation = &representation,
          .motion = &in_both<start>,
          .rate = Rate::angular_speed};
}

}  // namespace stiefel
