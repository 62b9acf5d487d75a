#include "engine/linalg/lie/orthogonal.h"

#include <Eigen/QR>

#include "engine/numbers/quadruple.h"

namespace stiefel {

template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k) {
  const Eigen::HouseholderQR<Matrix<Scalar>> qr(A);
  return qr.householderQ() * Matrix<Scalar>::Identity(A.rows(), k);
}

template Matrix<double> orthonormal_columns(const Matrix<double>& A, Eigen::Index k);
template Matrix<long double> orthonormal_columns(const Matrix<long double>& A, Eigen::Index k);
template Matrix<Quad> orthonormal_columns(const Matrix<Quad>& A, Eigen::Index k);

}  // namespace stiefel
