#pragma once

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/dense/decompositions.h"
#include "engine/numbers/parallel.h"
#include "stiefel/stop.h"

// What decompositions.h declares, in any real scalar.
namespace stiefel {

/// Writes the orthogonal H, n × n, of A = HTHᵀ, T of Hessenberg form. Unlike Eigen's product of
/// reflections, it does not allocate. `workspace` has n numbers.
template <class Scalar>
void write_householder_product(const Eigen::HessenbergDecomposition<Matrix<Scalar>>& A,
                               Vector<Scalar>& workspace, Matrix<Scalar>& H) {
  const Matrix<Scalar>& packed = A.packedMatrix();
  const Eigen::Index n = packed.rows();
  H.setIdentity(n, n);
  for (Eigen::Index k = n - 2; k >= 0; --k)
    H.bottomRightCorner(n - k - 1, n - k - 1)
        .applyHouseholderOnTheLeft(packed.col(k).tail(n - k - 2),
                                   A.householderCoefficients().coeff(k), workspace.data());
}

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
void Lu<Scalar>::solve(const Eigen::Ref<const Matrix<Scalar>>& B, Matrix<Scalar>& X) const {
  X.resize(B.rows(), B.cols());
  const double operations = static_cast<double>(B.rows()) * static_cast<double>(B.size());
  in_wide_ranges(B.cols(), operations / 8, [&](auto begin, auto end) {
    X.middleCols(begin, end - begin) = lu_.solve(B.middleCols(begin, end - begin));
  });
}

template <class Scalar>
Matrix<Scalar> Lu<Scalar>::solve(const Eigen::Ref<const Matrix<Scalar>>& B) const {
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
Scalar skew_norm(const Matrix<Scalar>& M) {
  using std::sqrt;
  const Scalar size = M.size() == 0 ? Scalar(0) : Scalar(M.cwiseAbs().maxCoeff());
  if (!(size > 0)) return size;
  stop_point(3 * static_cast<double>(M.rows() * M.size()));
  // Scaled, so that the square of M neither overflows nor underflows.
  const Matrix<Scalar> unit = M / size, square = unit.transpose() * unit;
  return size * sqrt(symmetric_eigenvalues(square)(M.cols() - 1));
}

template <class Scalar>
SymmetricEigen3<Scalar> symmetric_eigen_3(const Eigen::Matrix<Scalar, 3, 3>& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<Scalar, 3, 3>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k, Eigen::Index first) {
  const Eigen::HouseholderQR<Matrix<Scalar>> qr(A);
  const Eigen::Index N = A.rows();
  return qr.householderQ() * Matrix<Scalar>::Identity(N, N).middleCols(first, k);
}

/// Computes the Schur form of the Hessenberg matrix T, and with `vectors` multiplies U by its
/// unitary factor. Iterates in pieces, before each of which it checks for a stop request: with
/// vectors and N = 512 the whole takes seconds.
template <class Complex>
void iterate_schur(Eigen::ComplexSchur<Matrix<Complex>>& schur, const Matrix<Complex>& T,
                   const Matrix<Complex>& U, bool vectors) {
  constexpr Eigen::Index of_piece = 32, most_of_row = 30;
  const auto N = static_cast<double>(T.rows());
  schur.setMaxIterations(of_piece);
  const auto piece = [&](const Matrix<Complex>& from, const Matrix<Complex>& by) {
    stop_point((vectors ? 20 : 10) * of_piece * N * N);
    schur.computeFromHessenberg(from, by, vectors);
  };
  piece(T, U);
  for (Eigen::Index k = of_piece; k < most_of_row * T.rows(); k += of_piece) {
    if (schur.info() == Eigen::Success) return;
    piece(schur.matrixT(), vectors ? schur.matrixU() : U);
  }
}

template <class Scalar>
Lyapunov<Scalar>::Lyapunov(Eigen::Index N)
    : hessenberg_(N), schur_(N), real_(N, N), Y_(N, N), product_(N, N), workspace_(N) {
  // Initialises the factors with those of the identity, so that a copy made before `factor` reads
  // no uninitialised numbers.
  Y_.setIdentity();
  schur_.computeFromHessenberg(Y_, Y_, false);
}

template <class Scalar>
void Lyapunov<Scalar>::factor(const Matrix<Scalar>& A) {
  stop_point(20 * static_cast<double>(A.rows() * A.size()));
  hessenberg_.compute(A);
  stop_point();
  write_householder_product(hessenberg_, workspace_, real_);
  product_ = real_.template cast<Complex>();
  real_ = hessenberg_.matrixH();
  Y_ = real_.template cast<Complex>();
  iterate_schur(schur_, Y_, product_, true);
}

template <class Scalar>
Scalar Lyapunov<Scalar>::smallest_pair_sum() const {
  Scalar least = std::numeric_limits<Scalar>::infinity(), second = least;
  for (Eigen::Index i = 0; i < Y_.rows(); ++i) {
    const Scalar w = schur_.matrixT()(i, i).real();
    if (w < least) {
      second = least;
      least = w;
    } else if (w < second) {
      second = w;
    }
  }
  return least + second;
}

template <class Scalar>
Scalar Lyapunov<Scalar>::smallest_real_part() const {
  return schur_.matrixT().diagonal().real().minCoeff();
}

template <class Scalar>
void Lyapunov<Scalar>::solve(const Matrix<Scalar>& G, Matrix<Scalar>& Y) {
  const auto& Z = schur_.matrixU();
  const auto& T = schur_.matrixT();
  const Eigen::Index N = Y_.rows();
  Y_ = G.template cast<Complex>();
  stop_point();
  product_.noalias() = Z.adjoint() * Y_;
  stop_point();
  Y_.noalias() = product_ * Z;
  for (Eigen::Index j = 0; j < N; ++j) {
    stop_point(6 * static_cast<double>(N * N));
    for (Eigen::Index k = 0; k < j; ++k) Y_.col(j) -= T(k, j) * Y_.col(k);
    for (Eigen::Index i = 0; i < N; ++i) {
      Complex sum = Y_(i, j);
      for (Eigen::Index k = 0; k < i; ++k) sum -= std::conj(T(k, i)) * Y_(k, j);
      Y_(i, j) = sum / (std::conj(T(i, i)) + T(j, j));
    }
  }
  stop_point(16 * static_cast<double>(N * N * N));
  product_.noalias() = Z * Y_;
  stop_point();
  Y_.noalias() = product_ * Z.adjoint();
  Y = Y_.real();
}

template <class Scalar>
SymmetricLyapunov<Scalar>::SymmetricLyapunov(Eigen::Index n)
    : tridiagonal_(n),
      eigen_(n),
      V_(n, n),
      product_(n, n),
      d_(n),
      diagonal_(n),
      subdiagonal_(n > 0 ? n - 1 : 0),
      workspace_(n) {}

template <class Scalar>
void SymmetricLyapunov<Scalar>::factor(const Matrix<Scalar>& K) {
  if (K.rows() == 1) {
    k_ = K(0, 0);
    return;
  }
  stop_point(6 * static_cast<double>(K.rows() * K.size()));
  const Scalar scale = K.cwiseAbs().maxCoeff();
  product_ = K / scale;
  tridiagonal_.compute(product_);
  diagonal_ = tridiagonal_.packedMatrix().diagonal();
  subdiagonal_ = tridiagonal_.packedMatrix().template diagonal<-1>();
  eigen_.computeFromTridiagonal(diagonal_, subdiagonal_);
  d_ = scale * eigen_.eigenvalues();
  write_householder_product(tridiagonal_, workspace_, product_);
  V_.noalias() = product_ * eigen_.eigenvectors();
}

template <class Scalar>
void SymmetricLyapunov<Scalar>::solve(const Matrix<Scalar>& E, Matrix<Scalar>& X) {
  if (E.rows() == 1) {
    X(0, 0) = E(0, 0) / (2 * k_);
    return;
  }
  stop_point(4 * static_cast<double>(E.rows() * E.size()));
  product_.noalias() = V_.transpose() * E;
  X.noalias() = product_ * V_;
  for (Eigen::Index j = 0; j < X.cols(); ++j)
    for (Eigen::Index i = 0; i < X.rows(); ++i) X(i, j) /= d_(i) + d_(j);
  stop_point();
  product_.noalias() = V_ * X;
  X.noalias() = product_ * V_.transpose();
}

template <class Scalar>
Exponential<Scalar>::Exponential(Eigen::Index N, MatrixKind of)
    : of_(of),
      scaled_(N, N),
      square_(N, N),
      fourth_(N, N),
      sixth_(N, N),
      odd_(N, N),
      even_(N, N),
      lu_(N) {}

template <class Scalar>
void Exponential<Scalar>::operator()(const Matrix<Scalar>& A, Matrix<Scalar>& D) {
  static constexpr std::array<Scalar, 8> b = {17297280, 8648640, 1995840, 277200,
                                              25200,    1512,    56,      1};
  using std::isfinite, std::ldexp;
  // The largest norm of A that the approximant takes unscaled is Higham's bound for 53 bits. The
  // error grows like the 14th power of the norm, which gives the bounds for other precisions.
  static const Scalar largest =
      static_cast<Scalar>(0.95 * std::exp2((53 - std::numeric_limits<Scalar>::digits) / 14.0));
  int doublings = 0;
  for (Scalar norm = A.cwiseAbs().colwise().sum().maxCoeff(); norm > largest && isfinite(norm);
       norm /= 2)
    ++doublings;
  if (doublings > 0) scaled_ = ldexp(Scalar(1), -doublings) * A;
  const Matrix<Scalar>& scaled = doublings > 0 ? scaled_ : A;

  square_.noalias() = scaled * scaled;
  fourth_.noalias() = square_ * square_;
  sixth_.noalias() = fourth_ * square_;
  even_ = b[7] * sixth_ + b[5] * fourth_ + b[3] * square_;
  even_.diagonal().array() += b[1];
  odd_.noalias() = scaled * even_;
  even_ = b[6] * sixth_ + b[4] * fourth_ + b[2] * square_;
  even_.diagonal().array() += b[0];
  stop_point();
  even_ -= odd_;
  lu_.factor(even_);
  odd_ *= Scalar(2);
  lu_.solve(odd_, D);
  for (int k = 0; k < doublings; ++k) {
    odd_.noalias() = D * D;
    D = Scalar(2) * D + odd_;
    if (of_ == MatrixKind::skew && (k % 4 == 3 || (k > 3 && k == doublings - 1)))
      restore_orthogonality(D);
  }
}

/// Projects I + D to the orthogonal matrices, with UᵀU − I = D + Dᵀ + DᵀD.
template <class Scalar>
void Exponential<Scalar>::restore_orthogonality(Matrix<Scalar>& D) {
  even_.noalias() = D.transpose() * D;
  even_ += D + D.transpose();
  odd_ = even_;
  odd_.noalias() += D * even_;
  D -= odd_ / 2;
}

template <class Scalar>
bool ConstraintRiccati<Scalar>::solve(const Matrix<Scalar>& A, const Matrix<Scalar>& P,
                                      const Matrix<Scalar>& E, Matrix<Scalar>& Y) {
  return Y.rows() == 1 ? closed(A(0, 0), P(0, 0), E(0, 0), Y(0, 0)) : newton(A, P, E, Y);
}

template <class Scalar>
bool ConstraintRiccati<Scalar>::closed(Scalar a, Scalar p, Scalar e, Scalar& Y) {
  using std::sqrt;
  const Scalar square = a * a - p * e;
  if (!(square > 0)) return false;
  Y = a > 0 ? -e / (a + sqrt(square)) : (sqrt(square) - a) / p;
  return true;
}

template <class Scalar>
bool ConstraintRiccati<Scalar>::newton(const Matrix<Scalar>& A, const Matrix<Scalar>& P,
                                       const Matrix<Scalar>& E, Matrix<Scalar>& Y) {
  const Scalar enough = std::numeric_limits<Scalar>::epsilon() / 4 * E.cwiseAbs().maxCoeff();
  constexpr int most = 30;
  for (int k = 0; k < most; ++k) {
    stop_point(6 * static_cast<double>(Y.rows() * Y.size()));
    PY_.noalias() = P * Y;
    C_ = A + PY_;
    delta_.noalias() = Y * A;
    product_.noalias() = Y * PY_;
    product_ += E + delta_ + delta_.transpose();
    if (!product_.allFinite()) return false;
    lyapunov_.factor(C_);
    lyapunov_.solve(product_, delta_);
    product_ = (delta_ + delta_.transpose()) / 2;
    Y -= product_;
    PY_.noalias() = P * product_;
    delta_.noalias() = product_ * PY_;
    if (delta_.cwiseAbs().maxCoeff() <= enough) return lyapunov_.smallest_real_part() > 0;
  }
  return false;
}

template <class Scalar>
SkewFlow<Scalar>::SkewFlow(const Matrix<Scalar>& A) : XY_(A.rows(), 2 * A.rows()) {
  auto [w, X, Y] = skew_eigen(A);
  XY_ << X, Y;
  turned_ = XY_;
  w_ = std::move(w);
}

template <class Scalar>
void SkewFlow<Scalar>::operator()(Scalar t, Matrix<Scalar>& E) {
  using std::cos, std::sin;
  const Eigen::Index n = w_.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Scalar c = cos(w_(i) * t), s = sin(w_(i) * t);
    turned_.col(i) = c * XY_.col(i) + s * XY_.col(n + i);
    turned_.col(n + i) = c * XY_.col(n + i) - s * XY_.col(i);
  }
  stop_point(2 * static_cast<double>(n * n * n));
  E.noalias() = turned_ * XY_.transpose();
}

}  // namespace stiefel
