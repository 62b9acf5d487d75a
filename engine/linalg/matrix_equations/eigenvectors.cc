#include "engine/linalg/matrix_equations/eigenvectors.h"

#include "stiefel/stop.h"

namespace Eigen::internal {

template <class Scalar>
using Solver = SelfAdjointEigenSolver<stiefel::Matrix<Scalar>>;
template <class Scalar>
using Reals = typename Solver<Scalar>::RealVectorType;
template <class Scalar>
using Below = typename Solver<Scalar>::SubDiagonalType;
template <class Scalar>
using Coefficients = typename Tridiagonalization<stiefel::Matrix<Scalar>>::CoeffVectorType;

/// Repeats Eigen's reduction to tridiagonal form, operation by operation, with a check for a stop
/// request before each column: of a Hermitian matrix with N = 1024 it takes most of a second.
template <class Scalar>
void reduce(stiefel::Matrix<Scalar>& A, Coefficients<Scalar>& h) {
  const Index n = A.rows();
  for (Index i = 0; i < n - 1; ++i) {
    stiefel::stop_point();
    const Index left = n - i - 1;
    double beta;
    Scalar tau;
    A.col(i).tail(left).makeHouseholderInPlace(tau, beta);
    // The similarity transformation by I - tau v v^H, v = A.col(i).tail(left).
    A.col(i).coeffRef(i + 1) = 1;
    h.tail(left).noalias() = A.bottomRightCorner(left, left).template selfadjointView<Lower>() *
                             (numext::conj(tau) * A.col(i).tail(left));
    h.tail(left) +=
        (numext::conj(tau) * -0.5 * (h.tail(left).dot(A.col(i).tail(left)))) * A.col(i).tail(left);
    A.bottomRightCorner(left, left)
        .template selfadjointView<Lower>()
        .rankUpdate(A.col(i).tail(left), h.tail(left), Scalar(-1));
    A.col(i).coeffRef(i + 1) = beta;
    h.coeffRef(i) = tau;
  }
}

/// Repeats Eigen's QR iteration on the tridiagonal form, operation by operation, with a check for a
/// stop request before each step: with complex eigenvectors it takes most of a second at N = 512.
template <class Scalar>
ComputationInfo iterate(Reals<Scalar>& diagonal, Below<Scalar>& below, const Index most,
                        bool with_vectors, stiefel::Matrix<Scalar>& vectors) {
  constexpr double least = std::numeric_limits<double>::min();
  constexpr double inverse_unit = 1 / std::numeric_limits<double>::epsilon();
  const Index n = diagonal.size();
  const auto negligible = [&](Index i) {
    const double scaled = inverse_unit * below[i];
    return std::abs(below[i]) < least ||
           scaled * scaled <= std::abs(diagonal[i]) + std::abs(diagonal[i + 1]);
  };
  Index start = 0, end = n - 1;
  for (Index steps = 0; end > 0;) {
    for (Index i = start; i < end; ++i)
      if (negligible(i)) below[i] = 0;
    while (end > 0 && below[end - 1] == 0) --end;
    if (end <= 0) break;
    if (++steps > most * n) return NoConvergence;
    for (start = end - 1; start > 0 && below[start - 1] != 0;) --start;
    stiefel::stop_point();
    tridiagonal_qr_step<ColMajor>(diagonal.data(), below.data(), start, end,
                                  with_vectors ? vectors.data() : nullptr, n);
  }
  for (Index i = 0; i < n - 1; ++i) {
    Index k = 0;
    diagonal.segment(i, n - i).minCoeff(&k);
    if (k == 0) continue;
    std::swap(diagonal[i], diagonal[k + i]);
    if (with_vectors) vectors.col(i).swap(vectors.col(k + i));
  }
  return Success;
}

template <>
void tridiagonalization_inplace(stiefel::Matrix<double>& A, Coefficients<double>& h) {
  reduce<double>(A, h);
}
template <>
void tridiagonalization_inplace(stiefel::Matrix<std::complex<double>>& A,
                                Coefficients<std::complex<double>>& h) {
  reduce<std::complex<double>>(A, h);
}
template <>
ComputationInfo computeFromTridiagonal_impl(Reals<double>& diagonal, Below<double>& below,
                                            const Index most, bool with_vectors,
                                            stiefel::Matrix<double>& vectors) {
  return iterate<double>(diagonal, below, most, with_vectors, vectors);
}
template <>
ComputationInfo computeFromTridiagonal_impl(Reals<std::complex<double>>& diagonal,
                                            Below<std::complex<double>>& below, const Index most,
                                            bool with_vectors,
                                            stiefel::Matrix<std::complex<double>>& vectors) {
  return iterate<std::complex<double>>(diagonal, below, most, with_vectors, vectors);
}

}  // namespace Eigen::internal

template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<double>>& Eigen::SelfAdjointEigenSolver<
    stiefel::Matrix<double>>::compute(const Eigen::EigenBase<stiefel::Matrix<double>>&, int);
template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<double>>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<double>>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<std::complex<double>>>&, int);
