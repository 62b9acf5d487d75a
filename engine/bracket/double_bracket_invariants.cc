#include "engine/bracket/double_bracket_invariants.h"

#include <algorithm>

#include "engine/dense/decompositions.h"

namespace stiefel {

Vector<double> singular_values(const Matrix<std::complex<double>>& Q,
                               const Matrix<std::complex<double>>& P, std::complex<double> a,
                               std::complex<double> b) {
  const Matrix<std::complex<double>> Z = a * Q + b * P;
  const Matrix<double> X = Z.real().transpose(), Y = Z.imag().transpose();
  const Eigen::Index p = Z.rows(), q = Z.cols();
  // [[0, R], [Rᵀ, 0]] with Z as a real matrix R = [[Re Z, −Im Z], [Im Z, Re Z]].
  Matrix<double> S = Matrix<double>::Zero(2 * (p + q), 2 * (p + q));
  S.bottomLeftCorner(2 * q, 2 * p) << X, Y, -Y, X;
  const Vector<double> w = symmetric_eigenvalues(S);
  Vector<double> values(std::min(p, q));
  for (Eigen::Index k = 0; k < values.size(); ++k) values(k) = w(w.size() - 1 - 2 * k);
  return values;
}

}  // namespace stiefel
