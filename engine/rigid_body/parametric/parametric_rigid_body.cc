#include <array>

#include "engine/catalogue/series_start.h"
#include "engine/rigid_body/parametric/parametric_forms.h"
#include "engine/rigid_body/parametric/parametric_psi.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {
namespace {

WithinDomain<Expression> write(const Phase& x, const ConversionTarget& target, Margins& margins) {
  return write_parametric(1, x, target, margins);
}
constexpr Representation representation = {.square = true,
                                           .read = read_parametric,
                                           .write = write,
                                           .has_epsilon = true,
                                           .has_parameter = true};

constexpr auto start = [](const auto& g) {
  const auto Q = g.block("Q");
  auto made = g.start(Q, parametric_momentum(Q, g.block("P")) / g.epsilon);
  made.presentation.diagonal = g.mu * g.lambda.cwiseAbs2();
  return made;
};

/// Whether Omega is constant, so that a step by the exponential is exact.
bool turns_evenly(const Scene& scene) {
  const Eigen::VectorXd& lambda = scene.inertia();
  return lambda.size() == 2 || (lambda.array() == lambda(0)).all();
}

constexpr std::array recommendations = {
    Recommendation{.where = "N = 2, or Lambda a multiple of the identity",
                   .takes = turns_evenly,
                   .method = "munthe_kaas4",
                   .order = 4},
    with_error_control(5e-14, 0.1)};

}  // namespace

SystemEntry parametric_rigid_body_entry() {
  SystemInfo info = parametric_info("M = (Q^-1 P - P^-1 Q) / epsilon - mu Lambda^2, skew");
  info.name = "parametric_rigid_body";
  info.summary = "rigid body in GL(N) with the spectral parameter mu";
  info.equations = "Q' = Q (Omega + mu Lambda), P' = P (Omega + mu Lambda), Omega = J^-1(M)";
  info.source = "[RB] (8.4)-(8.6)";
  info.file = "engine/rigid_body/parametric/parametric_rigid_body.h";
  return {.info = info,
          .check = [](SceneDraft& draft) { check_parametric(draft, 1); },
          .recommended = recommendations,
          .representation = &representation,
          .motion = &in_both<parametric_equations, start>,
          .example_step = 0.4};
}

}  // namespace stiefel
