#include "engine/body/mclachlan_scovel_blocks.h"

#include "engine/body/rigid_body_data.h"
#include "engine/body/rigid_forms.h"
#include "engine/body/view.h"
#include "engine/motion/representation.h"
#include "engine/motion/series_start.h"

namespace stiefel {
namespace {

/// Checks (Q, B) with QᵀB skew, or (Q, M).
void check(SceneDraft& draft) {
  draft.refuse_if(draft.given().epsilon.has_value(), "epsilon");
  if (!check_symmetric_frame(draft) || !check_either(draft, "B", "M")) return;
  const Eigen::MatrixXd& Q = draft.scene().Q();
  const Eigen::Index N = Q.rows();
  if (const RowMatrix* M = draft.block("M", N, N, false)) {
    draft.set_skew("M", *M);
    if (draft.sound()) draft.set_block("B", B_of_M<double>(Q, draft.scene().M()));
  }
  if (const RowMatrix* B = draft.block("B", N, N, false)) {
    const double defect = skewness_defect<double>(Q, *B);
    // The bound is no stricter than that on Q, which may have been repaired.
    if (!(defect <= draft.largest_repair() * B->cwiseAbs().maxCoeff()))
      return draft.refuse("initial.B", "max |QᵀB + BᵀQ| = " + to_text(defect),
                          "QᵀB must be skew-symmetric to " + to_text(draft.largest_repair()));
    const Eigen::MatrixXd M = M_of_B<double>(Q, *B);
    if (draft.check_momentum("initial.B", M)) draft.set_block("B", Q * M);
  }
}

WithinDomain<Phase> read(const Scene& scene, Margins&) {
  return phase_of_body(scene, scene.Q(), M_of_B(scene.Q(), scene.block("B")));
}
WithinDomain<FormBlocks> write(const Phase& x, const ConversionTarget&, Margins&) {
  return FormBlocks{{{"Q", x.Q}, {"B", B_of_M(x.Q, x.M)}}};
}
constexpr Representation representation = {true, read, write};

constexpr auto start = [](const auto& g) {
  const auto Q = g.block("Q");
  return g.start(Q, M_of_B(Q, g.block("B")));
};

BodyView view(const Scene& scene) {
  const Eigen::Index N = scene.dimension();
  const auto with_frame = [N](const Eigen::MatrixXd& x, Eigen::MatrixXd bottom) {
    Eigen::MatrixXd y = x;
    y.bottomRows(N) = bottom;
    return y;
  };
  return {.body =
              [=](const auto& x) {
                return with_frame(x, M_of_B<double>(x.topRows(N), x.bottomRows(N)));
              },
          .blocks =
              [=](const auto& x) {
                return with_frame(x, B_of_M<double>(x.topRows(N), x.bottomRows(N)));
              }};
}

}  // namespace

SystemEntry mclachlan_scovel_entry() {
  SystemInfo info = rigid_form_info({"B", "N x N", false, "B = Q M, so that Q^T B is skew"}, false);
  info.name = "mclachlan_scovel";
  info.summary = "rigid body in the variables of McLachlan and Scovel";
  info.equations = "Q' = Q J^-1(Q^T B), B' = B J^-1(Q^T B), M = Q^T B";
  info.source = "[RB] (5.5)";
  info.file = "engine/body/mclachlan_scovel.cc";
  return view_of_rigid_body(std::move(info), check, representation, view,
                            in_both<body_equations, start>);
}

}  // namespace stiefel
