#pragma once

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/dense/decompositions.h"
#include "engine/dense/householder.h"
#include "engine/numbers/stoppable_product.h"
#include "stiefel/stop.h"

// The decompositions in any real scalar.
namespace stiefel {

/// Makes a real symmetric tridiagonal S of a skew A, with iA = HDSD†Hᵀ, D = diag(1, i, −1, −i, …):
/// S has the zero diagonal and the elements below it of HᵀAH. Returns the eigenvalues of S, and
/// with `vectors` H and its eigenvectors V.
template <class Scalar>
Vector<Scalar> skew_eigenvalues(const Matrix<Scalar>& A, Matrix<Scalar>* H, Matrix<Scalar>* V) {
  const Eigen::Index n = A.rows();
  if (n == 0) return {};
  stop_point(4 * static_cast<double>(n * n * n));
  using std::frexp, std::ldexp;
  int exponent = 0;
  frexp(A.cwiseAbs().maxCoeff(), &exponent);
  exponent = std::max(exponent, std::numeric_limits<Scalar>::min_exponent);
  const Scalar scale = ldexp(Scalar(1), exponent);  // a power of two, so that A is not rounded
  const Eigen::HessenbergDecomposition<Matrix<Scalar>> reduced(ldexp(Scalar(1), -exponent) * A);
  if (H != nullptr) {
    stop_point(4 * static_cast<double>(n * n * n));
    Vector<Scalar> workspace(n);
    H->resize(n, n);
    write_householder_product(reduced, workspace, *H);
  }
  const Vector<Scalar> zero = Vector<Scalar>::Zero(n),
                       below = reduced.packedMatrix().template diagonal<-1>();
  Eigen::SelfAdjointEigenSolver<Matrix<Scalar>> solver;
  solver.computeFromTridiagonal(zero, below,
                                V ? Eigen::ComputeEigenvectors : Eigen::EigenvaluesOnly);
  if (V != nullptr) *V = solver.eigenvectors();
  return scale * solver.eigenvalues();
}

template <class Scalar>
Lu<Scalar>::Lu(Eigen::Index N) : lu_(N) {}

template <class Scalar>
Lu<Scalar>::Lu(const Matrix<Scalar>& A) : lu_(A) {}

template <class Scalar>
void Lu<Scalar>::factor(const Matrix<Scalar>& A) {
  lu_.compute(A);
}

template <class Scalar>
void Lu<Scalar>::solve(const Matrix<Scalar>& B, Matrix<Scalar>& X) const {
  X.resize(B.rows(), B.cols());
  by_blocks<Scalar, false>(
      B.rows(), B.cols(), static_cast<double>(B.rows()),
      [&](Eigen::Index, Eigen::Index, Eigen::Index j, Eigen::Index columns) {
        X.middleCols(j, columns) = lu_.solve(B.middleCols(j, columns));
      },
      [&] { X = lu_.solve(B); });
}

template <class Scalar>
Matrix<Scalar> Lu<Scalar>::solve(const Matrix<Scalar>& B) const {
  Matrix<Scalar> X;
  solve(B, X);
  return X;
}

template <class Scalar>
Scalar Lu<Scalar>::inverse_condition() const {
  return lu_.rcond();
}

template <class Scalar>
bool factor_positive(Matrix<Scalar>& A) {
  return Eigen::LLT<Eigen::Ref<Matrix<Scalar>>>(A).info() == Eigen::Success;
}

template <class Scalar>
void solve_positive(const Matrix<Scalar>& L, Matrix<Scalar>& B) {
  L.template triangularView<Eigen::Lower>().solveInPlace(B);
  L.adjoint().template triangularView<Eigen::Upper>().solveInPlace(B);
}
template <class Scalar>
SymmetricEigen<Scalar>::SymmetricEigen(const Matrix<Scalar>& A) {
  factor(A);
}

template <class Scalar>
void SymmetricEigen<Scalar>::factor(const Matrix<Scalar>& A) {
  stop_point();
  solver_.compute(A);
}

template <class Scalar>
Matrix<Scalar> SymmetricEigen<Scalar>::inverse_root() const {
  return solver_.operatorInverseSqrt();
}

template <class Scalar>
Vector<Scalar> symmetric_eigenvalues(const Matrix<Scalar>& A) {
  stop_point();
  return Eigen::SelfAdjointEigenSolver<Matrix<Scalar>>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

template <class Scalar>
SkewEigen<Scalar> skew_eigen(const Matrix<Scalar>& A) {
  SkewEigen<Scalar> out;
  const Eigen::Index n = A.rows();
  Matrix<Scalar> H, V;
  out.w = skew_eigenvalues(A, &H, &V);
  // Z = HDV: the rows of V with 1 and −1 in D make X, those with i and −i make Y.
  Matrix<Scalar> real = Matrix<Scalar>::Zero(n, n), imaginary = real;
  for (Eigen::Index k = 0; k < n; ++k)
    (k % 2 == 0 ? real : imaginary).row(k) = Scalar(k % 4 < 2 ? 1 : -1) * V.row(k);
  stop_point(2 * static_cast<double>(n * n * n));
  out.X = H * real;
  out.Y = H * imaginary;
  return out;
}

template <class Scalar>
Vector<Scalar> skew_eigenvalues(const Matrix<Scalar>& A) {
  return skew_eigenvalues<Scalar>(A, nullptr, nullptr);
}

template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k, Eigen::Index first) {
  const Eigen::HouseholderQR<Matrix<Scalar>> qr(A);
  const Eigen::Index N = A.rows();
  return qr.householderQ() * Matrix<Scalar>::Identity(N, N).middleCols(first, k);
}

}  // namespace stiefel
