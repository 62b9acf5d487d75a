#include <Eigen/SVD>
#include <algorithm>

#include "engine/dense/cayley_midpoint.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/decompositions_of.h"
#include "engine/dense/orthogonal.h"

namespace stiefel {

template class Lu<double>;

template bool factor_positive(Matrix<double>& A);
template void solve_positive(const Matrix<double>& L, Matrix<double>& B);

template Vector<double> symmetric_eigenvalues(const Matrix<double>& A);

template SkewEigen<double> skew_eigen(const Matrix<double>& A);
template Vector<double> skew_eigenvalues(const Matrix<double>& A);

template double skew_norm(const Matrix<double>& M);

template Matrix<double> orthonormal_columns(const Matrix<double>&, Index, Index);

template SymmetricEigen3<double> symmetric_eigen_3(const Eigen::Matrix<double, 3, 3>& A);

template class Lyapunov<double>;
template class SymmetricLyapunov<double>;
template class ConstraintRiccati<double>;

template class Exponential<double>;
template class SkewFlow<double>;
template class CayleyMidpoint<SoN<double>>;

template Matrix<double> nearest_orthogonal(Matrix<double> Q);

Matrix<double> repaired(const Matrix<double>& Q) {
  const double rounding = 4 * static_cast<double>(Q.cols()) * 0x1p-53;
  return orthogonality_defect(Q) > rounding ? nearest_orthogonal<double>(Q) : Q;
}

double determinant(const Matrix<double>& A) { return A.determinant(); }

Eigen::Vector3d solve_3(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  return A.partialPivLu().solve(b);
}

SymmetricEigen symmetric_eigen(const Matrix<double>& A) {
  stop_point();
  const Eigen::SelfAdjointEigenSolver<Matrix<double>> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Matrix<double> symmetric_inverse_root(const Matrix<double>& A) {
  stop_point();
  return Eigen::SelfAdjointEigenSolver<Matrix<double>>(A).operatorInverseSqrt();
}

void solve_positive(const Matrix<double>& L, Vector<double>& b) {
  L.triangularView<Eigen::Lower>().solveInPlace(b);
  L.adjoint().triangularView<Eigen::Upper>().solveInPlace(b);
}

void divide_by_lower(const Matrix<double>& L, Matrix<double>& B) {
  constexpr Index columns = 32;
  for (Index k = 0; k < B.cols(); k += columns) {
    const Index now = std::min(columns, B.cols() - k);
    stop_point(0.7 * static_cast<double>(now * L.size()));
    auto some = B.middleCols(k, now);
    L.triangularView<Eigen::Lower>().solveInPlace(some);
  }
}

Matrix<double> triangular_factor(const Matrix<double>& A) {
  const Eigen::HouseholderQR<Matrix<double>> qr(A);
  return qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>();
}

RealSchur real_schur(const Matrix<double>& A) {
  const Eigen::RealSchur<Matrix<double>> schur(A);
  return {schur.matrixT(), schur.matrixU()};
}

RightSingular right_singular(const Matrix<double>& A) {
  const Eigen::JacobiSVD<Matrix<double>, Eigen::NoQRPreconditioner> svd(A, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

Vector<std::complex<double>> spectrum(const Matrix<double>& A) {
  stop_point(10 * static_cast<double>(A.rows() * A.size()));
  const Eigen::HessenbergDecomposition<Matrix<double>> reduced(A);
  const Matrix<double> T = reduced.matrixH();
  const Matrix<std::complex<double>> H = T.cast<std::complex<double>>();
  Eigen::ComplexSchur<Matrix<std::complex<double>>> schur(A.rows());
  iterate_schur(schur, H, H, false);
  return schur.matrixT().diagonal();
}

Matrix<double> principal_root(const Matrix<double>& A) {
  constexpr int most = 60;
  const Matrix<double> I = Matrix<double>::Identity(A.rows(), A.cols());
  Matrix<double> X = A, Y = I;
  for (int k = 0; k < most; ++k) {
    stop_point(3 * static_cast<double>(A.rows() * A.size()));
    const Matrix<double> next = (X + Lu<double>(Y).solve(I)) / 2;
    stop_point();
    Y = ((Y + Lu<double>(X).solve(I)) / 2).eval();
    const double change = (next - X).cwiseAbs().maxCoeff();
    X = next;
    if (!(change > 1e-15 * X.cwiseAbs().maxCoeff())) break;
  }
  return X;
}

}  // namespace stiefel
