// Decompositions in long double and quadruple precision. g++ compiles the two files in less time
// than one.
#include "engine/dense/decompositions_of.h"
#include "engine/numbers/quadruple.h"

namespace stiefel {

template class Lu<long double>;
template class Lu<Quad>;
template bool factor_positive(Matrix<long double>& A);
template bool factor_positive(Matrix<Quad>& A);
template void solve_positive(const Matrix<long double>& L, Matrix<long double>& B);
template void solve_positive(const Matrix<Quad>& L, Matrix<Quad>& B);
template SkewEigen<long double> skew_eigen(const Matrix<long double>& A);
template Matrix<long double> orthonormal_columns(const Matrix<long double>&, Index, Index);
template SymmetricEigen3<long double> symmetric_eigen_3(const Eigen::Matrix<long double, 3, 3>& A);
template SymmetricEigen3<Quad> symmetric_eigen_3(const Eigen::Matrix<Quad, 3, 3>& A);
template class Lyapunov<long double>;
template class SymmetricLyapunov<long double>;
template class SymmetricLyapunov<Quad>;
template class Exponential<long double>;
template class SkewFlow<long double>;

}  // namespace stiefel
