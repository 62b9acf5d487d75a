#include "engine/linalg/matrix_equations/stoppable_schur.h"

#include <algorithm>
#include <limits>

#include "stiefel/stop.h"

namespace {

using Eigen::Index;

/// Whether |T_{i+1,i}| is at the rounding level of its neighbours on the diagonal; if so, sets it
/// to 0.
template <class Real, class T>
bool negligible(T& matrix, Index i) {
  using Eigen::numext::norm1;
  stiefel::stop_point();
  const Real diagonal = norm1(matrix.coeff(i, i)) + norm1(matrix.coeff(i + 1, i + 1));
  const Real below = norm1(matrix.coeff(i + 1, i));
  if (!Eigen::internal::isMuchSmallerThan(below, diagonal, std::numeric_limits<Real>::epsilon()))
    return false;
  matrix.coeffRef(i + 1, i) = 0;
  return true;
}

/// The reduction to Hessenberg form.
template <class Scalar>
void reduce(stiefel::Matrix<Scalar>& A, auto& coefficients, auto& workspace) {
  const Index n = A.rows();
  workspace.resize(n);
  for (Index i = 0; i < n - 1; ++i) {
    if (i % 16 == 0) stiefel::stop_point();
    const Index left = n - i - 1;
    double beta;
    Scalar h;
    A.col(i).tail(left).makeHouseholderInPlace(h, beta);
    A.col(i).coeffRef(i + 1) = beta;
    coefficients.coeffRef(i) = h;
    A.bottomRightCorner(left, left)
        .applyHouseholderOnTheLeft(A.col(i).tail(left - 1), h, &workspace.coeffRef(0));
    A.rightCols(left).applyHouseholderOnTheRight(A.col(i).tail(left - 1), Eigen::numext::conj(h),
                                                 &workspace.coeffRef(0));
  }
}

}  // namespace

template <>
bool Eigen::ComplexSchur<stiefel::Matrix<std::complex<double>>>::subdiagonalEntryIsNeglegible(
    Index i) {
  return negligible<double>(m_matT, i);
}

template <>
bool Eigen::ComplexSchur<stiefel::Matrix<std::complex<long double>>>::subdiagonalEntryIsNeglegible(
    Index i) {
  return negligible<long double>(m_matT, i);
}

template <>
Eigen::Index Eigen::RealSchur<stiefel::Matrix<double>>::findSmallSubdiagEntry(
    Index last, const double& considered_zero) {
  stiefel::stop_point();
  Index i = last;
  for (; i > 0; --i) {
    const double diagonal = std::abs(m_matT.coeff(i - 1, i - 1)) + std::abs(m_matT.coeff(i, i));
    const double unit = std::numeric_limits<double>::epsilon();
    if (std::abs(m_matT.coeff(i, i - 1)) <= std::max(diagonal * unit, considered_zero)) break;
  }
  return i;
}

template <>
void Eigen::HessenbergDecomposition<stiefel::Matrix<std::complex<double>>>::_compute(
    stiefel::Matrix<std::complex<double>>& A, CoeffVectorType& coefficients,
    VectorType& workspace) {
  reduce<std::complex<double>>(A, coefficients, workspace);
}
template <>
void Eigen::HessenbergDecomposition<stiefel::Matrix<double>>::_compute(
    stiefel::Matrix<double>& A, CoeffVectorType& coefficients, VectorType& workspace) {
  reduce<double>(A, coefficients, workspace);
}
