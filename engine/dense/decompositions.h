#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <limits>

#include "engine/numbers/scalar.h"

/// Decompositions of dense matrices, compiled once, in decompositions.cc. A request to stop
/// (stiefel/stop.h) is seen before a decomposition and not within it.
namespace stiefel {

/// The factors PA = LU with partial pivoting of an N × N matrix A. For double, long double and
/// Quad.
template <class Scalar>
class Lu {
 public:
  /// Reserves memory; factoring and solving then allocate nothing.
  explicit Lu(Eigen::Index N);
  explicit Lu(const Matrix<Scalar>& A);

  void factor(const Matrix<Scalar>& A);

  /// Sets X = A⁻¹B, by blocks of columns that the threads of the crew share, with a check for a
  /// stop request before each. X must be another matrix than B.
  void solve(const Matrix<Scalar>& B, Matrix<Scalar>& X) const;
  Matrix<Scalar> solve(const Matrix<Scalar>& B) const;

  /// Returns an estimate of 1/(‖A‖₁‖A⁻¹‖₁).
  Scalar inverse_condition() const;

 private:
  Eigen::PartialPivLU<Matrix<Scalar>> lu_;
};

double determinant(const Matrix<double>& A);

/// Replaces the lower triangle of a symmetric A, of which it reads nothing else, by that of L, A =
/// LLᵀ. Returns false, with A lost, where A is not positive definite. For double, long double and
/// Quad.
template <class Scalar>
bool factor_positive(Matrix<Scalar>& A);

/// Replaces B by (LLᵀ)⁻¹B. L is the lower triangle of a matrix.
template <class Scalar>
void solve_positive(const Matrix<Scalar>& L, Matrix<Scalar>& B);
void solve_positive(const Matrix<double>& L, Vector<double>& b);

/// Replaces B by L⁻¹B, with a check for a stop request before each 32 columns.
void divide_by_lower(const Matrix<double>& L, Matrix<double>& B);

/// The eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix, of which it
/// reads the lower triangle. For double and long double.
template <class Scalar>
class SymmetricEigen {
 public:
  SymmetricEigen() = default;
  explicit SymmetricEigen(const Matrix<Scalar>& A);

  void factor(const Matrix<Scalar>& A);

  const Vector<Scalar>& values() const { return solver_.eigenvalues(); }
  const Matrix<Scalar>& vectors() const { return solver_.eigenvectors(); }

  /// Returns A^{−1/2}.
  Matrix<Scalar> inverse_root() const;

 private:
  Eigen::SelfAdjointEigenSolver<Matrix<Scalar>> solver_;
};
template <class Scalar>
Vector<Scalar> symmetric_eigenvalues(const Matrix<Scalar>& A);

/// The eigenvalues, ascending, and eigenvectors of a symmetric 3 × 3 matrix. For double, long
/// double and Quad.
template <class Scalar>
struct SymmetricEigen3 {
  Vector3<Scalar> values;
  Eigen::Matrix<Scalar, 3, 3> vectors;
};
template <class Scalar>
SymmetricEigen3<Scalar> symmetric_eigen_3(const Eigen::Matrix<Scalar, 3, 3>& A);

/// The eigenvalues iw of a skew A with iA = Z diag(w) Z†, w ascending, and Z = X + iY unitary. For
/// double and long double.
template <class Scalar>
struct SkewEigen {
  Vector<Scalar> w;
  Matrix<Scalar> X, Y;
};
template <class Scalar>
SkewEigen<Scalar> skew_eigen(const Matrix<Scalar>& A);
template <class Scalar>
Vector<Scalar> skew_eigenvalues(const Matrix<Scalar>& A);

/// Returns columns first, ..., first + k − 1 of the orthogonal N × N factor of the QR decomposition
/// of A, which has N rows, by Householder's reflections: the columns of A made orthonormal, then
/// columns that complete them to a basis. For double and long double.
template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k, Eigen::Index first = 0);

/// Returns R, k × k, of the QR decomposition of a matrix with k columns and as many rows or more.
Matrix<double> triangular_factor(const Matrix<double>& A);

/// Returns the x that minimises ‖Ax − b‖ by QR with pivoting. Columns whose pivot is below
/// `threshold` times the largest do not count.
Vector<double> least_squares(const Matrix<double>& A, const Vector<double>& b,
                             double threshold = std::numeric_limits<double>::epsilon());

/// The real Schur form A = ZTZᵀ, T with blocks of one and two rows on the diagonal. For N = 512 it
/// takes more than a second.
struct RealSchur {
  Matrix<double> T, Z;
};
RealSchur real_schur(const Matrix<double>& A);

/// The singular values, descending, and right singular vectors of a square A.
struct RightSingular {
  Vector<double> values;
  Matrix<double> vectors;
};
RightSingular right_singular(const Matrix<double>& A);

/// Returns the eigenvalues of a real N × N matrix.
Vector<std::complex<double>> spectrum(const Matrix<double>& A);

/// Returns A^{1/2} with its spectrum in Re > 0, for a real N × N matrix A without eigenvalues on
/// (−∞, 0]. Iterates X ← ½(X + Y⁻¹), Y ← ½(Y + X⁻¹) from X = A, Y = I (Denman and Beavers 1976);
/// convergence is quadratic.
Matrix<double> principal_root(const Matrix<double>& A);

}  // namespace stiefel
