#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>

#include "engine/numbers/scalar.h"

/// Decompositions of dense matrices, matrix equations and exponentials, compiled once, in
/// decompositions.cc. A request to stop (stiefel/stop.h) is seen before a decomposition and not
/// within it.
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
  void solve(const Eigen::Ref<const Matrix<Scalar>>& B, Matrix<Scalar>& X) const;
  Matrix<Scalar> solve(const Eigen::Ref<const Matrix<Scalar>>& B) const;

  /// Returns an estimate of 1/(‖A‖₁‖A⁻¹‖₁).
  Scalar inverse_condition() const;

 private:
  Eigen::PartialPivLU<Matrix<Scalar>> lu_;
};

double determinant(const Matrix<double>& A);

/// Returns A⁻¹b of a 3 × 3 matrix.
Eigen::Vector3d solve_3(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);

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

/// The eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix, of which the
/// lower triangle is read.
struct SymmetricEigen {
  Vector<double> values;
  Matrix<double> vectors;
};
SymmetricEigen symmetric_eigen(const Matrix<double>& A);
template <class Scalar>
Vector<Scalar> symmetric_eigenvalues(const Matrix<Scalar>& A);

/// Returns A^{−1/2} of a symmetric positive definite A.
Matrix<double> symmetric_inverse_root(const Matrix<double>& A);

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

/// Returns ‖M‖_op of an N × N matrix to rounding, which for a skew M is the largest |eigenvalue|.
template <class Scalar>
Scalar skew_norm(const Matrix<Scalar>& M);

/// Returns the Casimirs of so(N)*: w ≥ 0 of the eigenvalues ±iw of M, in descending order, one for
/// each pair. Computed from MᵀM they would keep only half the digits.
template <class Scalar>
Vector<Scalar> casimirs(const Matrix<Scalar>& M) {
  return skew_eigenvalues(M).reverse().head(M.cols() / 2);
}

/// Returns columns first, ..., first + k − 1 of the orthogonal N × N factor of the QR decomposition
/// of A, which has N rows, by Householder's reflections: the columns of A made orthonormal, then
/// columns that complete them to a basis. For double and long double.
template <class Scalar>
Matrix<Scalar> orthonormal_columns(const Matrix<Scalar>& A, Eigen::Index k, Eigen::Index first = 0);

/// Returns R, k × k, of the QR decomposition of a matrix with k columns and as many rows or more.
Matrix<double> triangular_factor(const Matrix<double>& A);

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

/// Solves AᵀY + YA = G for real N × N matrices by the complex Schur form A = ZTZᴴ (Bartels and
/// Stewart 1972): Tᴴ Ŷ + Ŷ T = Zᴴ G Z, column by column. The solution is unique when no two
/// eigenvalues of A sum to 0.
template <class Scalar>
class Lyapunov {
 public:
  using Complex = std::complex<Scalar>;

  explicit Lyapunov(Eigen::Index N);

  void factor(const Matrix<Scalar>& A);

  /// Returns the smallest Re(w_i + w_j), i < j, over the eigenvalues w of A.
  Scalar smallest_pair_sum() const;

  /// Returns the smallest Re w over the eigenvalues w of A.
  Scalar smallest_real_part() const;

  /// Solves for Y with the factors of A. Y may be G.
  void solve(const Matrix<Scalar>& G, Matrix<Scalar>& Y);

 private:
  Eigen::HessenbergDecomposition<Matrix<Scalar>> hessenberg_;
  Eigen::ComplexSchur<Matrix<Complex>> schur_;
  Matrix<Scalar> real_;
  Matrix<Complex> Y_, product_;
  Vector<Scalar> workspace_;
};

/// Solves KX + XK = E for K symmetric positive definite, n × n, and any E: with K = VDVᵀ, (VᵀXV)_ij
/// = (VᵀEV)_ij / (d_i + d_j). A symmetric E gives a symmetric X. Does not allocate after
/// construction.
template <class Scalar>
class SymmetricLyapunov {
 public:
  explicit SymmetricLyapunov(Eigen::Index n);

  void factor(const Matrix<Scalar>& K);

  /// Solves for X with the factors of K. X may be E.
  void solve(const Matrix<Scalar>& E, Matrix<Scalar>& X);

 private:
  Eigen::HessenbergDecomposition<Matrix<Scalar>> tridiagonal_;
  Eigen::SelfAdjointEigenSolver<Matrix<Scalar>> eigen_;
  Matrix<Scalar> V_, product_;
  Vector<Scalar> d_, diagonal_, subdiagonal_, workspace_;
  Scalar k_{};
};

/// Finds the multiplier of a constraint on frames: the symmetric n × n matrix Y for which Q′ = D +
/// YG has orthonormal rows. With A = GDᵀ, P = GGᵀ and E = DDᵀ − I, it solves
///
///     Q′Q′ᵀ − I = E + YA + AᵀY + YPY = 0
///
/// on the branch spec(C) in Re > 0, C = A + PY = GQ′ᵀ; there is at most one such Y. Newton's method
/// is CᵀδY + δY C = −(Q′Q′ᵀ − I). The equation is quadratic, so after a correction Q′Q′ᵀ − I = δY P
/// δY exactly; the iteration stops when δY P δY is at rounding level. n = 1 is solved in closed
/// form. Does not allocate after construction.
template <class Scalar>
class ConstraintRiccati {
 public:
  explicit ConstraintRiccati(Eigen::Index n)
      : lyapunov_(n), C_(n, n), PY_(n, n), delta_(n, n), product_(n, n) {}

  /// Starts from the given Y. Returns false, and leaves Y undefined, if it finds no solution on the
  /// branch.
  bool solve(const Matrix<Scalar>& A, const Matrix<Scalar>& P, const Matrix<Scalar>& E,
             Matrix<Scalar>& Y);

 private:
  /// Solves pY² + 2aY + e = 0 with a + pY > 0.
  static bool closed(Scalar a, Scalar p, Scalar e, Scalar& Y);

  bool newton(const Matrix<Scalar>& A, const Matrix<Scalar>& P, const Matrix<Scalar>& E,
              Matrix<Scalar>& Y);

  Lyapunov<Scalar> lyapunov_;
  Matrix<Scalar> C_, PY_, delta_, product_;
};

enum class MatrixKind { skew, general };

/// Computes D = exp(A) − I of a real N × N matrix A, by the diagonal Padé approximant of degree 7
/// with scaling and squaring (Higham 2005): r = (V − U)⁻¹(V + U), U odd and V even in A. D is
/// computed directly and doubled by exp(2A) − I = 2D + D², so it is relatively accurate for small
/// A. For a skew A, r is orthogonal to rounding. Each doubling doubles the rounding error, so some
/// are then followed by the projection of U = I + D to the orthogonal matrices, U ← U(3I − UᵀU)/2.
/// Allocates at construction only. For double and long double.
template <class Scalar>
class Exponential {
 public:
  Exponential(Eigen::Index N, MatrixKind of);

  void operator()(const Matrix<Scalar>& A, Matrix<Scalar>& D);

 private:
  void restore_orthogonality(Matrix<Scalar>& D);

  MatrixKind of_;
  Matrix<Scalar> scaled_, square_, fourth_, sixth_, odd_, even_;
  Lu<Scalar> lu_;
};

/// Computes exp(tA) of one skew A, n × n, for any t at the same cost: with iA = Z w Z†, w real,
/// exp(tA) = Z e^{−iwt} Z†, orthogonal to rounding for every t: with Z = X + iY it is the product
/// of [X cos wt + Y sin wt, Y cos wt − X sin wt] with [X Y]ᵀ. Does not allocate after construction.
template <class Scalar>
class SkewFlow {
 public:
  explicit SkewFlow(const Matrix<Scalar>& A);

  void operator()(Scalar t, Matrix<Scalar>& E);

 private:
  Matrix<Scalar> XY_, turned_;
  Vector<Scalar> w_;
};

}  // namespace stiefel
