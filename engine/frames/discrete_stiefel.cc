#include "engine/frames/frame_tangents.h"
#include "engine/frames/stiefel_forms.h"
#include "stiefel/invariant_names.h"

namespace stiefel {
namespace {

void check(SceneDraft& draft) {
  if (!check_stiefel_frame(draft)) return;
  const auto& Q = draft.scene().Q();
  if (const RowMatrix* Q_prev = draft.block("Q_prev", Q.rows(), Q.cols()))
    draft.set_frame("Q_prev", *Q_prev);
}

// For n = N (55) is the map of Moser and Veselov. For n < N it is a motion of its own, which has no
// other form.

OutsideDomain not_square(const Eigen::MatrixXd& Q) {
  return {"n = N", static_cast<double>(Q.rows()), static_cast<double>(Q.cols())};
}

WithinDomain<Phase> read(const Scene& scene, Margins& margins) {
  const Eigen::MatrixXd& Q = scene.Q();
  if (Q.rows() != Q.cols()) return outside(not_square(Q), "initial.Q");
  return representations::moser_veselov_pair.read(scene, margins);
}
WithinDomain<Expression> write(const Phase& x, const ConversionTarget& target, Margins& margins) {
  if (!x.square()) return outside(not_square(x.Q), "to");
  return representations::moser_veselov_pair.write(x, target, margins);
}
constexpr Representation representation = {.square = false, .read = read, .write = write};

}  // namespace

SystemEntry discrete_stiefel_entry() {
  SystemInfo info{};
  info.blocks = {{"Q_prev", "n x N", true, "frame one step before, orthonormal rows"},
                 {"Q", "n x N", true, "frame, orthonormal rows"}};
  info.fields = {{"Q_prev", "n x N", "frame one step before"},
                 {"Q", "n x N", "frame, orthonormal rows"}};
  info.invariants = {
      {family::spatial_momentum, "Q Lambda Q_prev^T - Q_prev Lambda Q^T, n x n", "[ST] (57)"},
      {family::lax,
       "coefficients of mu^j in tr L(mu)^k, "
       "L(mu) = Lambda^2 + mu (Q_prev^T Q Lambda - Lambda Q^T Q_prev) - mu^2 Q_prev^T Q_prev",
       "[ST] (61)"},
      {family::orthogonality, "Q Q^T = I", ""},
  };
  info.name = "discrete_stiefel";
  info.summary =
      "discrete variational problem of Moser and Veselov on V(n, N); for n < N an integrable map "
      "of its own (n = 1: the discrete Neumann system), NOT a discretisation of the geodesic "
      "flow: after ten steps from a geodesic it is off by 0.3 to 1, at h = 0.2, 0.02 and 0.002 "
      "alike";
  info.equations = "Q_{k+1} Lambda + Q_{k-1} Lambda = B_k Q_k, B_k symmetric";
  info.source = "[ST] (55)";
  info.file = "engine/frames/body/discrete_stiefel.h";
  info.discrete = true;
  return {.info = info,
          .check = check,
          .representation = &representation,
          .tangents = &discrete_stiefel_tangents};
}

}  // namespace stiefel
