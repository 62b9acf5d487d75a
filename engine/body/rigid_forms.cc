#include "engine/body/rigid_forms.h"

#include <cmath>

#include "engine/body/body_invariants.h"
#include "engine/body/discrete_pairs.h"
#include "engine/dense/inertia_operator.h"
#include "engine/dense/orthogonal.h"

namespace stiefel {
namespace {

constexpr Eigen::Index largest_manakov_unasked = 16;
using Wide = long double;

/// Adds the coefficients of μʲ in tr(M + μΛ²)ᵏ, scaled by C(k,j) ‖M‖ᵏ⁻ʲ ‖Λ²‖ʲ. Those with k − j odd
/// are 0, and the one with j = k is a constant of the scene.
void manakov_coefficients(const Vector<Wide>& lambda, const Matrix<Wide>& M, Wide norm,
                          InvariantList& out) {
  const int N = static_cast<int>(M.cols());
  const auto coefficients = manakov<Wide>(lambda, M, N, out.stop());
  const Wide lambda2 = lambda.cwiseAbs2().maxCoeff();
  for (int k = 2; k < static_cast<int>(coefficients.size()); ++k)
    for (int j = k % 2; j <= k - 2; j += 2) {
      const Wide binomial = std::exp(std::lgamma(k + 1.0L) - std::lgamma(j + 1.0L) -
                                     std::lgamma(static_cast<Wide>(k - j) + 1));
      out.add(family::manakov, indexed(family::manakov, k, j), coefficients[k][j],
              binomial * std::pow(norm, static_cast<Wide>(k - j)) *
                  std::pow(lambda2, static_cast<Wide>(j)));
    }
}

}  // namespace

std::vector<InvariantInfo> rigid_body_invariant_infos(Side side) {
  return {
      {family::energy, "1/2 tr(Lambda Omega^T Omega)", "[RB] section 2"},
      {family::spatial_momentum, side == Side::left ? "Q M Q^T" : "Q^T M Q", "[RB] Prop. 2.1"},
      {family::casimirs, "w_0 >= w_1 >= ... >= 0 of the eigenvalues +-i w_k of M",
       "[RB] section 2"},
      {family::manakov, "coefficients of mu^j in tr((M + mu Lambda^2)^k), k = 2..N", "[RB] (2.4)"},
  };
}

void rigid_body_invariants(Side side, const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                           const Eigen::MatrixXd& M, InvariantList& out, double terms) {
  const Vector<Wide> wide_lambda = lambda.cast<Wide>();
  const Matrix<Wide> wide_M = M.cast<Wide>();
  const bool at_rest = is_rounding(M.stableNorm(), terms);
  if (out.wants(family::energy)) {
    const Wide E = energy<Wide>(wide_lambda, wide_M), of_terms = terms;
    out.add(family::energy, E, at_rest ? of_terms * of_terms / (2 * wide_lambda.maxCoeff()) : E);
  }
  const bool manakov_wanted = out.wants(family::manakov, M.cols() <= largest_manakov_unasked);
  if (!manakov_wanted && !out.wants(family::spatial_momentum) && !out.wants(family::casimirs))
    return;
  const Eigen::VectorXd w = casimirs<double>(M);
  const double norm = at_rest ? terms : w(0);
  if (out.wants(family::spatial_momentum) && Q.size() > 0) {
    // [RB] Prop. 2.1: m_r = Q_rᵀM_rQ_r of the right-invariant body.
    const Eigen::MatrixXd m =
        spatial_momentum<double>(side == Side::left ? Q : Eigen::MatrixXd(Q.transpose()), M);
    out.add_skew(family::spatial_momentum, m, norm);
  }
  if (out.wants(family::casimirs))
    for (Eigen::Index k = 0; k < w.size(); ++k)
      out.add(family::casimirs, indexed(family::casimirs, k), w(k), norm);
  if (manakov_wanted) manakov_coefficients(wide_lambda, wide_M, norm, out);
}

void add_discrete_hamiltonian(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h,
                              InvariantList& out) {
  if (!out.wants(family::discrete_hamiltonian)) return;
  const Eigen::MatrixXd K = h * M;
  const auto U = J_D_inverse(lambda, K);
  if (!U) return;
  // Size of its two terms.
  const double size = static_cast<double>(K.cols()) + lambda.cwiseAbs().sum();
  if (const auto H = discrete_hamiltonian<double>(lambda, K, *U))
    out.add(family::discrete_hamiltonian, *H, size);
}

double angular_velocity_norm(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M) {
  return casimirs<double>(inverse_inertia<double>(lambda, M))(0);
}

SystemInfo rigid_form_info(BlockInfo other, bool has_P, Side side) {
  const bool left = side == Side::left;
  SystemInfo info{};
  info.blocks = {{"Q", "N x N", true, "frame, orthogonal"}, other};
  if (other.name != "M")
    info.blocks.push_back(
        {"M", "N x N", false, "momentum, skew: may be given instead of the block before it"});
  info.fields = {{"Q", "N x N", "frame, orthogonal"},
                 {other.name, other.shape, other.description},
                 {"M", "N x N", left ? "body momentum, skew" : "momentum, skew"},
                 {"Omega", "N x N",
                  left ? "body angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j)"
                       : "angular velocity: Omega_ij = M_ij / (lambda_i + lambda_j)"}};
  if (other.name == "M") info.fields.erase(info.fields.begin() + 1);
  info.invariants = rigid_body_invariant_infos(side);
  if (has_P) {
    info.fields.push_back(
        {"epsilon", "1 x 1",
         left ? "M = (Q^T P - P^T Q) / epsilon" : "M = (P Q^T - Q P^T) / epsilon"});
    info.invariants.push_back({family::PQt, left ? "P Q^T" : "P^T Q", "[RB] (8.2)"});
  }
  info.invariants.push_back({family::orthogonality, "Q Q^T = I", ""});
  info.side = side;
  info.momentum = "M";
  info.velocity = "Omega";
  return info;
}

void report_rigid_form(Observables& observables, const Scene& scene, const RigidForm& form) {
  const int N = scene.dimension();
  const Eigen::VectorXd& lambda = scene.inertia();
  if (observables.fields().back().name != "M")
    observables.field({"M", N, N}, [M = form.M](const auto& x, auto out) { out = M(x); });
  observables.field({"Omega", N, N}, [M = form.M, lambda](const auto& x, auto out) {
    out = inverse_inertia<double>(lambda, M(x));
  });
  if (form.scaled)
    observables.field({"epsilon", 1, 1},
                      [epsilon = scene.epsilon()](const auto&, auto out) { out(0, 0) = epsilon; });
  observables.all_invariants = [=, discrete = scene.method().empty(), h = scene.step()](
                                   const Eigen::MatrixXd& x, InvariantList& out) {
    const Eigen::MatrixXd Q = form.Q(x), M = form.M(x);
    rigid_body_invariants(form.side, lambda, Q, M, out, form.terms ? form.terms(x) : 0);
    if (form.A && out.wants(family::PQt)) {
      const Eigen::MatrixXd A = form.A(x);
      out.add_elements(family::PQt, A, A.norm());
    }
    if (discrete) add_discrete_hamiltonian(lambda, M, h, out);
  };
  observables.frame_defect = [Q = form.Q](const Eigen::MatrixXd& x) {
    const Eigen::MatrixXd frame = Q(x);
    return frame.size() > 0 ? std::optional(orthogonality_defect(frame)) : std::nullopt;
  };
  observables.speed = [lambda, M = form.M](const Eigen::MatrixXd& x) {
    return angular_velocity_norm(lambda, M(x));
  };
}

}  // namespace stiefel
