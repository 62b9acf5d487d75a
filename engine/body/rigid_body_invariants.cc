#include "engine/body/rigid_body_invariants.h"

#include <algorithm>
#include <cmath>

#include "engine/body/body_invariants.h"
#include "engine/body/discrete_pairs.h"
#include "engine/dense/inertia_operator.h"
#include "engine/motion/stacked_observables.h"

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
    const Eigen::MatrixXd m =
        side == Side::left ? spatial_momentum<double>(Q, M) : right_momentum<double>(Q, M);
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

}  // namespace stiefel
