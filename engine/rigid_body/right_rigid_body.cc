#include "engine/catalogue/representation.h"
#include "engine/catalogue/series_start.h"
#include "engine/rigid_body/rigid_body_data.h"
#include "engine/rigid_body/rigid_forms.h"
#include "engine/rigid_body/view.h"

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
  auto of_left = g.start(g.block("Q").transpose(), -g.block("M"));
  of_left.presentation.right = true;
  return of_left;
};

BodyView view(const Scene&) {
  const auto other_side = [](const Eigen::MatrixXd& x) {
    const Eigen::Index N = x.cols();
    Eigen::MatrixXd y(2 * N, N);
    y << x.topRows(N).transpose(), -x.bottomRows(N);
    return y;
  };
  return {.body = other_side, .blocks = other_side};
}

}  // namespace

SystemEntry right_rigid_body_entry() {
  SystemInfo info = rigid_form_info({"M", "N x N", true, "momentum, skew"}, false, Side::right);
  info.name = "right_rigid_body";
  info.summary = "free rigid body in N dimensions, right-invariant";
  info.equations = "Q' = Omega Q, M' = [Omega, M], M = Lambda Omega + Omega Lambda";
  info.source = "[RB] (RightRBn), Prop. 2.1";
  info.file = "engine/rigid_body/right_rigid_body.cc";
  return {.info = info,
          .check = [](SceneDraft& draft) { check_rigid_body(draft, true); },
          .recommended = for_views,
          .representation = &representation,
          .view = view,
          .priced_as = "rigid_body",
          .motion = &in_both<body_equations, start>,
          .rate = Rate::angular_speed,
          .packs = &body_packs,
          .rates = &body_rates};
}

Simulations right_rigid_body_simulations() { return rigid_body_simulations(); }

}  // namespace stiefel
