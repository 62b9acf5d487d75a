#include <cmath>

#include "engine/body/discrete_pairs.h"
#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_forms.h"
#include "engine/body/view.h"
#include "engine/motion/method_entry.h"
#include "engine/motion/representation.h"
#include "engine/motion/series_start.h"
#include "engine/motion/two_form.h"
#include "engine/scene/scene_draft.h"
#include "engine/structure/tangent_spaces.h"

namespace stiefel {
namespace {

void check(SceneDraft& draft) {
  draft.refuse_other_numbers();
  draft.refuse_if(draft.given().body.has_value(), "body");
  if (!draft.set_inertia()) return;
  draft.check_inertia_sums();
  draft.check_block_names();
  const Eigen::Index N = draft.scene().dimension();
  for (const char* name : {"Q_prev", "Q"})
    if (const RowMatrix* Q = draft.block(name, N, N)) draft.set_frame(name, *Q);
}

/// Reads two frames by Σ_L.
WithinDomain<Phase> read(const Scene& scene, Margins& margins) {
  const Eigen::MatrixXd &Q_prev = scene.block("Q_prev"), &Q = scene.Q();
  margins.push_back({"S_L", margin_S_L(scene.inertia(), Q_prev, Q)});
  margins.push_back({"E_L", margin_E_L(scene.inertia(), Q_prev.transpose() * Q)});
  Eigen::MatrixXd M = Sigma_L(scene.inertia(), Q_prev, Q, scene.step());
  add_condition(M, inverse_condition_Sigma_L(scene.inertia(), M, scene.step()), margins);
  return phase_of_body(scene, Q, std::move(M));
}
WithinDomain<FormBlocks> write(const Phase& x, const ConversionTarget&, Margins& margins) {
  auto Q_prev = Sigma_L_inverse(x.lambda, x.Q, x.M, x.step);
  if (!Q_prev) return outside(Q_prev.error(), "step");
  margins.push_back({"S_L", margin_S_L(x.lambda, *Q_prev, x.Q)});
  margins.push_back({"E_L", margin_E_L(x.lambda, Q_prev->transpose() * x.Q)});
  add_condition(x.M, inverse_condition_Sigma_L(x.lambda, x.M, x.step), margins);
  return FormBlocks{{{"Q_prev", std::move(*Q_prev)}, {"Q", x.Q}}};
}
constexpr auto start = [](const auto& g) {
  using Dense = decltype(g.block("Q"));
  const Dense Q = g.block("Q"), W = g.lambda.asDiagonal() * (g.block("Q_prev").transpose() * Q);
  return g.start(Q, (W - W.transpose()) / typename Dense::Scalar(g.scene.step()));
};

constexpr TwoForm form = {
    {"Omega_L",
     {"Q_prev", "Q"},
     "1/2 tr(u_1 Lambda v_2^T - v_1 Lambda u_2^T) of u = (u_1, u_2), v = (v_1, v_2)",
     "[RB] (7.8)"},
    {"Q_prev", "Q"},
    [](const Scene& s) { return space_of(ConsecutiveRotations<double>{s.inertia()}); }};

/// M_k = Σ_L(Q_{k−1}, Q_k), and Q_{k−1} = Σ_L⁻¹(Q_k, M_k), which is not a number where rounding has
/// moved M_k beyond the edge of the domain.
BodyView view(const Scene& scene) {
  using Dense = Eigen::MatrixXd;
  const auto over = [](const Dense& top, const Dense& bottom) {
    Dense x(2 * top.rows(), top.cols());
    x << top, bottom;
    return x;
  };
  const Eigen::Index N = scene.dimension();
  return {.body =
              [=, lambda = scene.inertia(), h = scene.step()](const Dense& x) {
                const Dense Q = x.bottomRows(N);
                return over(Q, Sigma_L<double>(lambda, x.topRows(N), Q, h));
              },
          .blocks =
              [=, lambda = scene.inertia(), h = scene.step()](const Dense& x) {
                const Dense Q = x.topRows(N);
                const auto Q_prev = Sigma_L_inverse(lambda, Q, x.bottomRows(N), h);
                return over(Q_prev.value_or(Dense::Constant(N, N, std::nan(""))), Q);
              }};
}

}  // namespace

constinit const Representation representations::moser_veselov_pair = {
    .square = true, .read = read, .write = write};

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
  info.file = "engine/body/moser_veselov_pair.cc";
  info.discrete = true;
  info.velocity = {};
  info.momentum = {};
  info.invariants.push_back(discrete_hamiltonian_info);
  return {.info = info,
          .check = check,
          .make = make_rigid_body,
          .methods = keeps_all,
          .two_forms = {&form},
          .representation = &representations::moser_veselov_pair,
          .view = view,
          .priced_as = "moser_veselov",
          .motion = &in_both<body_equations, start>,
          .rate = Rate::angular_speed,
          .packs = &body_packs,
          .rates = &body_rates};
}

}  // namespace stiefel
