#include "engine/simulation/parametric_forms.h"

#include <cmath>

#include "engine/invariants/parametric_rigid_body.h"
#include "engine/linalg/lu.h"
#include "engine/simulation/rigid_body_invariants.h"
#include "engine/simulation/rigid_forms.h"
#include "engine/simulation/scene_draft.h"

namespace stiefel {
namespace {

/// hM = M_μ − μΛ².
Eigen::MatrixXd momentum(const Eigen::VectorXd& lambda, double mu, const Eigen::MatrixXd& Q,
                         const Eigen::MatrixXd& P) {
  Eigen::MatrixXd M = parametric_momentum<double>(Q, P);
  M.diagonal() -= mu * lambda.cwiseAbs2();
  return M;
}

/// ‖·‖_F of the matrices that it is a difference of, with what the solves add to their rounding.
double parametric_terms(const Eigen::VectorXd& lambda, double mu, const Eigen::MatrixXd& Q,
                        const Eigen::MatrixXd& P) {
  const auto solved = [](const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
    const auto lu = A.partialPivLu();
    return lu.solve(B).stableNorm() / lu.rcond();
  };
  return solved(Q, P) + solved(P, Q) + std::abs(mu) * lambda.cwiseAbs2().stableNorm();
}

}  // namespace

SystemInfo parametric_info(std::string_view momentum) {
  SystemInfo info{};
  info.blocks = {{"Q", "N x N", true, "invertible"}, {"P", "N x N", true, "invertible"}};
  info.fields = {{"Q", "N x N", "invertible"},
                 {"P", "N x N", "invertible"},
                 {"M", "N x N", momentum}};
  for (const auto& invariant : rigid_body_invariant_infos())
    if (invariant.name != "spatial_momentum") info.invariants.push_back(invariant);
  info.invariants.push_back({"PQ_inverse", "P Q^-1", "[RB] section 8"});
  return info;
}

void check_parametric(SceneDraft& draft, double h) {
  auto& given = draft.given();
  draft.refuse_if(given.body.has_value(), "body");
  draft.refuse_if(given.epsilon.has_value(), "epsilon");
  draft.refuse_if(!given.inertia_u.empty(), "inertia_u");
  draft.refuse_if(!given.inertia_v.empty(), "inertia_v");
  if (!std::isfinite(given.parameter.value_or(0)))
    draft.refuse("parameter", to_text(*given.parameter), "must be finite");
  given.parameter = given.parameter.value_or(0);
  if (!draft.set_inertia()) return;
  draft.check_inertia_sums();
  draft.check_block_names();
  const Eigen::Index N = draft.scene().dimension();
  for (const char* name : {"Q", "P"}) {
    const RowMatrix* block = draft.block(name, N, N);
    if (block == nullptr) continue;
    if (!(block->partialPivLu().rcond() > 1e-12))
      draft.refuse("initial." + std::string(name),
                   "1/condition " + to_text(block->partialPivLu().rcond()), "must be invertible");
    draft.set_block(name, *block);
  }
  if (!draft.sound()) return;
  const Eigen::MatrixXd M = momentum(draft.scene().inertia(), *given.parameter, draft.scene().Q(),
                                     draft.scene().block("P"));
  const double defect = (M + M.transpose()).cwiseAbs().maxCoeff();
  const double size = M.cwiseAbs().maxCoeff() + std::abs(*given.parameter);
  if (!(defect <= 1e-8 * size))
    draft.refuse("initial", "max |M + Mᵀ| = " + to_text(defect / std::abs(h)),
                 "M = Q⁻¹P − P⁻¹Q − μΛ² must be skew-symmetric");
}

StackedReadout parametric_readout(const Scene& scene, double h) {
  const int N = scene.dimension();
  const Eigen::VectorXd lambda = scene.inertia();
  const double mu = scene.parameter();
  const auto M = [=](const Eigen::MatrixXd& x) -> Eigen::MatrixXd {
    return momentum(lambda, mu, x.topRows(N), x.bottomRows(N)) / h;
  };
  StackedReadout readout(stacked(scene, "Q", "P"));
  readout.block("Q", 0, N).block("P", N, N);
  readout.field({"M", N, N}, [M](const auto& x, auto out) { out = M(x); });
  readout.invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    // M is a difference of G = Q⁻¹P and G⁻¹, which are near 1 when it is small.
    const double terms = parametric_terms(lambda, mu, x.topRows(N), x.bottomRows(N));
    rigid_body_invariants(Side::left, lambda, Eigen::MatrixXd(), M(x), out,
                          {.terms = terms / std::abs(h), .least_norm = 1 / std::abs(h)});
    if (!out.wants("PQ_inverse")) return;
    const Eigen::MatrixXd A =
        x.topRows(N).transpose().partialPivLu().solve(x.bottomRows(N).transpose()).transpose();
    for (Eigen::Index i = 0; i < N; ++i)
      for (Eigen::Index j = 0; j < N; ++j)
        out.add("PQ_inverse", indexed("PQ_inverse", i + 1, j + 1), A(i, j), A.norm());
  };
  readout.rate = [=](const Eigen::MatrixXd& x) { return angular_velocity_norm(lambda, M(x)); };
  return readout;
}

}  // namespace stiefel
