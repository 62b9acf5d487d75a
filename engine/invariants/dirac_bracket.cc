#include "engine/invariants/dirac_bracket.h"

#include <Eigen/Eigenvalues>
#include <complex>

namespace stiefel {
namespace {

/// Y + RYR = G for an orthogonal N × N matrix R: (I + R ⊗ Rᵀ)⁻¹ of [RB] (3.15), by R = ZdZ†, |d_i|
/// = 1, as in Lemma 3.10: Ŷ_ij = Ĝ_ij/(1 + d_id_j). Two Schur-sized factorings, O(N³); unique on S.
class OneProductEquation {
 public:
  explicit OneProductEquation(const Matrix<double>& R) : schur_(R.cast<std::complex<double>>()) {}

  Matrix<double> solve(const Matrix<double>& G) const {
    const auto& Z = schur_.matrixU();
    const auto d = schur_.matrixT().diagonal();  // R is normal: T is diagonal
    Eigen::MatrixXcd Y = Z.adjoint() * G.cast<std::complex<double>>() * Z;
    for (Eigen::Index j = 0; j < Y.cols(); ++j)
      for (Eigen::Index i = 0; i < Y.rows(); ++i) Y(i, j) /= 1.0 + d(i) * d(j);
    return (Z * Y * Z.adjoint()).real();
  }

 private:
  Eigen::ComplexSchur<Eigen::MatrixXcd> schur_;
};

}  // namespace

PairFunction::Jet PairFunction::at(const Matrix<double>& Q, const Matrix<double>& P) const {
  Jet jet{1, Matrix<double>::Zero(Q.rows(), Q.cols()), Matrix<double>::Zero(Q.rows(), Q.cols())};
  for (const auto& [A, B] : factors) {
    const double f = trace_product(A, Q) + trace_product(B, P);
    jet.by_Q = f * jet.by_Q + 2 * jet.value * A;
    jet.by_P = f * jet.by_P + 2 * jet.value * B;
    jet.value *= f;
  }
  return jet;
}

double dirac_bracket(const Matrix<double>& Q, const Matrix<double>& P, const PairFunction& F,
                     const PairFunction& K) {
  const auto f = F.at(Q, P), k = K.at(Q, P);
  const auto inner = [](const Matrix<double>& X, const Matrix<double>& Y) {
    return trace_product(X, Y) / 2;
  };
  const auto twice_symmetric = [](const Matrix<double>& X) -> Matrix<double> {
    return X + X.transpose();
  };
  const Matrix<double> R = Q * P.transpose();
  const OneProductEquation equation(R);
  return inner(k.by_P, f.by_Q) - inner(k.by_Q, f.by_P) -
         inner(twice_symmetric(k.by_P * Q.transpose()),
               equation.solve(R * twice_symmetric(f.by_Q * P.transpose()))) /
             2 +
         inner(twice_symmetric(k.by_Q * P.transpose()),
               equation.solve(twice_symmetric(f.by_P * Q.transpose()) * R)) /
             2;
}

}  // namespace stiefel
