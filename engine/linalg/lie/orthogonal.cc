#include "engine/linalg/lie/orthogonal.h"

#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/numbers/quadruple.h"

namespace stiefel {

Matrix<double> repaired(const Matrix<double>& Q) {
  const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
  return orthogonality_defect(Q) > rounding ? nearest_orthogonal<double>(Q) : Q;
}

template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k) {
  const Eigen::HouseholderQR<Matrix<Scalar>> qr(A);
  return qr.householderQ() * Matrix<Scalar>::Identity(A.rows(), k);
}

template Matrix<double> nearest_orthogonal(Matrix<double> Q);
template Matrix<double> orthonormal_columns(const Matrix<double>& A, Eigen::Index k);
template Matrix<long double> orthonormal_columns(const Matrix<long double>& A, Eigen::Index k);
template Matrix<Quad> orthonormal_columns(const Matrix<Quad>& A, Eigen::Index k);

}  // namespace stiefel
