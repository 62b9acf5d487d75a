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

template <class Scalar>
using RealOf = typename NumTraits<Scalar>::Real;

/// Repeats Eigen's reduction to tridiagonal form, operation by operation, with a check for a stop
/// request before each column: of a Hermitian matrix with N = 1024 it takes most of a second.
template <class Scalar>
void reduce(stiefel::Matrix<Scalar>& A, Coefficients<Scalar>& h) {
  const Index n = A.rows();
  for (Index i = 0; i < n - 1; ++i) {
    stiefel::stop_point();
    const Index left = n - i - 1;
    RealOf<Scalar> beta;
    Scalar tau;
    A.col(i).tail(left).makeHouseholderInPlace(tau, beta);
    // The similarity transformation by I - tau v v^H, v = A.col(i).tail(left).
    A.col(i).coeffRef(i + 1) = 1;
    h.tail(left).noalias() = A.bottomRightCorner(left, left).template selfadjointView<Lower>() *
                             (numext::conj(tau) * A.col(i).tail(left));
    h.tail(left) +=
        (numext::conj(tau) * RealOf<Scalar>(-0.5) * (h.tail(left).dot(A.col(i).tail(left)))) *
        A.col(i).tail(left);
    A.bottomRightCorner(left, left)
        .template selfadjointView<Lower>()
        .rankUpdate(A.col(i).tail(left), h.tail(left), Scalar(-1));
    A.col(i).coeffRef(i + 1) = beta;
    h.coeffRef(i) = tau;
  }
}

/// The reduction, and the unitary Q of it in its place, with a check for a stop request before each
/// reflection.
template <class Scalar, bool is_complex>
struct tridiagonalization_inplace_selector<stiefel::Matrix<Scalar>, Dynamic, is_complex> {
  static void run(stiefel::Matrix<Scalar>& A, auto& diagonal, auto& below, Coefficients<Scalar>& h,
                  bool with_Q) {
    const Index n = A.rows();
    reduce<Scalar>(A, h);
    diagonal = A.diagonal().real();
    below = A.template diagonal<-1>().real();
    if (!with_Q) return;
    stiefel::Vector<Scalar> workspace(n);
    A.diagonal().setOnes();
    A.template triangularView<StrictlyUpper>().setZero();
    for (Index k = n - 2; k >= 0; --k) {
      stiefel::stop_point();
      A.bottomRightCorner(n - k - 1, n - k - 1)
          .applyHouseholderOnTheLeft(A.col(k).tail(n - k - 2), numext::conj(h.coeff(k)),
                                     workspace.data());
      A.col(k).tail(n - k - 1).setZero();
    }
    A.col(0).tail(n - 1).setZero();
  }
};

/// Repeats Eigen's QR iteration on the tridiagonal form, operation by operation, with a check for a
/// stop request before each step: with complex eigenvectors it takes most of a second at N = 512.
template <class Scalar>
ComputationInfo iterate(Reals<Scalar>& diagonal, Below<Scalar>& below, const Index most,
                        bool with_vectors, stiefel::Matrix<Scalar>& vectors) {
  using Real = RealOf<Scalar>;
  constexpr Real least = std::numeric_limits<Real>::min();
  constexpr Real inverse_unit = 1 / std::numeric_limits<Real>::epsilon();
  const Index n = diagonal.size();
  const auto negligible = [&](Index i) {
    const Real scaled = inverse_unit * below[i];
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

#define STIEFEL_STOPPABLE(Scalar)                                                            \
  template <>                                                                                \
  void tridiagonalization_inplace(stiefel::Matrix<Scalar>& A, Coefficients<Scalar>& h) {     \
    reduce<Scalar>(A, h);                                                                    \
  }                                                                                          \
  template <>                                                                                \
  ComputationInfo computeFromTridiagonal_impl(Reals<Scalar>& diagonal, Below<Scalar>& below, \
                                              const Index most, bool with_vectors,           \
                                              stiefel::Matrix<Scalar>& vectors) {            \
    return iterate<Scalar>(diagonal, below, most, with_vectors, vectors);                    \
  }
STIEFEL_STOPPABLE(double)
STIEFEL_STOPPABLE(long double)
STIEFEL_STOPPABLE(std::complex<double>)
STIEFEL_STOPPABLE(std::complex<long double>)
#undef STIEFEL_STOPPABLE

}  // namespace Eigen::internal

#define STIEFEL_SOLVER(Scalar)                                     \
  template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<Scalar>>& \
  Eigen::SelfAdjointEigenSolver<stiefel::Matrix<Scalar>>::compute( \
      const Eigen::EigenBase<stiefel::Matrix<Scalar>>&, int);
STIEFEL_SOLVER(double)
STIEFEL_SOLVER(long double)
STIEFEL_SOLVER(std::complex<double>)
STIEFEL_SOLVER(std::complex<long double>)
#undef STIEFEL_SOLVER
