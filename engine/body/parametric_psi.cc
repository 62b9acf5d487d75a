#include "engine/body/parametric_psi.h"

#include <cmath>
#include <complex>
#include <limits>

#include "engine/body/psi.h"

namespace stiefel {
namespace {

constexpr double on_the_cut = 1e-12;

Matrix<double> half_of(const Vector<double>& lambda, const Matrix<double>& M, double mu,
                       double epsilon) {
  Matrix<double> W = epsilon * M;
  W.diagonal() += epsilon * mu * lambda.cwiseAbs2();
  return W / 2;
}

Matrix<double> one_plus_square(const Matrix<double>& W) {
  return Matrix<double>::Identity(W.rows(), W.cols()) + W * W;
}

struct Nearest {
  double margin = std::numeric_limits<double>::infinity();
  std::complex<double> z;
};

/// Returns the eigenvalue of I + W² nearest to (−∞, 0]; if several lie on it, the one of largest
/// modulus.
Nearest nearest_to_the_cut(const Matrix<double>& square) {
  Nearest nearest;
  const auto eigenvalues = spectrum(square);
  for (const std::complex<double> z : eigenvalues) {
    const double distance = z.real() > 0 ? std::abs(z) : std::abs(z.imag());
    const double margin = distance > on_the_cut ? distance : 0;
    const bool farther = margin == 0 && z.real() < nearest.z.real();
    if (margin < nearest.margin || farther) nearest = {margin, z};
  }
  return nearest;
}

}  // namespace

Matrix<double> parametric_Psi(const Matrix<double>& Q, const Matrix<double>& P, double epsilon) {
  const Matrix<double> M = parametric_momentum<double>(Q, P) / 2;
  return (M - M.transpose()) / epsilon;
}

MatrixWithin<double> parametric_Psi_inverse(const Vector<double>& lambda, const Matrix<double>& Q,
                                            const Matrix<double>& M, double mu, double epsilon) {
  const Matrix<double> W = half_of(lambda, M, mu, epsilon), square = one_plus_square(W);
  if (!square.allFinite())
    return std::unexpected(OutsideDomain{"S_M^mu", 2 * W.cwiseAbs().maxCoeff(), 2});
  const Nearest nearest = nearest_to_the_cut(square);
  if (!(nearest.margin > 0))  // z = 1 − (w/2)²
    return std::unexpected(OutsideDomain{"S_M^mu", 2 * std::sqrt(std::abs(1.0 - nearest.z)), 2});
  return Matrix<double>(Q * (W + principal_root(square)));
}

double margin_parametric(const Vector<double>& lambda, const Matrix<double>& M, double mu,
                         double epsilon) {
  return nearest_to_the_cut(one_plus_square(half_of(lambda, M, mu, epsilon))).margin;
}

double inverse_condition_parametric(const Matrix<double>& Q, const Matrix<double>& P,
                                    const Matrix<double>& M, double epsilon) {
  const Matrix<double> G = Lu<double>(Q).solve(P), inverse = Lu<double>(P).solve(Q);
  return std::abs(epsilon) * skew_norm(M) / (skew_norm(G) * (1 + std::pow(skew_norm(inverse), 2)));
}

double parametric_epsilon(const Vector<double>& lambda, const Matrix<double>& M, double mu) {
  return unit_epsilon_of(skew_norm(M) + std::abs(mu) * lambda.cwiseAbs2().maxCoeff());
}

}  // namespace stiefel
