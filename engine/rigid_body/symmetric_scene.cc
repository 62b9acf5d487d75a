#include "engine/rigid_body/symmetric_scene.h"

#include <cmath>

#include "engine/rigid_body/symmetric/left_right.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel_blocks.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric/scaling.h"

namespace stiefel {
namespace {

/// Checks Λ and Q, which all these systems have. Returns false if there is a violation.
bool check_frame(SceneDraft& draft) {
  draft.refuse_if(draft.given().body.has_value(), "body");
  draft.refuse_if(!draft.given().inertia_u.empty(), "inertia_u");
  draft.refuse_if(!draft.given().inertia_v.empty(), "inertia_v");
  draft.refuse_if(draft.given().parameter.has_value(), "parameter");
  if (!draft.set_inertia()) return false;
  draft.check_inertia_sums();
  draft.check_block_names();
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* Q = draft.block("Q", N, N)) draft.set_frame("Q", *Q);
  return draft.sound();
}

/// Checks that the scene has exactly one of the two blocks.
bool check_either(SceneDraft& draft, const std::string& one, const std::string& other) {
  if (draft.has_block(one) != draft.has_block(other)) return true;
  draft.refuse("initial", draft.has_block(one) ? one + " and " + other : "neither",
               "must hold exactly one of " + one + " and " + other);
  return false;
}

void set_P_of_M(SceneDraft& draft, const RowMatrix& given_M, bool right) {
  draft.set_skew("M", given_M);
  if (!draft.sound()) return;
  const Eigen::MatrixXd &Q = draft.scene().Q(), &M = draft.scene().M();
  auto& epsilon = draft.given().epsilon;
  if (!epsilon) epsilon = unit_epsilon(M);
  auto P = right ? Psi_right_inverse(Q, M, *epsilon) : Psi_inverse(Q, M, *epsilon);
  if (!P)
    return draft.refuse("epsilon", to_text(*epsilon),
                        "epsilon ‖M‖_op = " + to_text(P.error().value) + " must be < 2; without " +
                            "epsilon the scene takes " + to_text(unit_epsilon(M)));
  draft.set_block("P", std::move(*P));
}

}  // namespace

void check_symmetric(SceneDraft& draft, bool right, std::optional<double> of_paper) {
  if (!check_frame(draft)) return;
  auto& epsilon = draft.given().epsilon;
  if (epsilon && !(std::isfinite(*epsilon) && *epsilon != 0))
    return draft.refuse("epsilon", to_text(*epsilon), "must be finite and not 0");
  if (!check_either(draft, "P", "M")) return;
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* M = draft.block("M", N, N, false)) set_P_of_M(draft, *M, right);
  if (const RowMatrix* P = draft.block("P", N, N, false)) {
    if (!epsilon) epsilon = of_paper.value_or(1);
    if (!draft.sound()) return;
    const Eigen::MatrixXd& Q = draft.scene().Q();
    const Eigen::MatrixXd M =
        right ? Psi_right<double>(Q, *P, *epsilon) : Psi<double>(Q, *P, *epsilon);
    if (draft.check_momentum("initial.P", M)) draft.set_block("P", *P);
  }
}

void check_mclachlan_scovel(SceneDraft& draft) {
  draft.refuse_if(draft.given().epsilon.has_value(), "epsilon");
  if (!check_frame(draft) || !check_either(draft, "B", "M")) return;
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

}  // namespace stiefel
