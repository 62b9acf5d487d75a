#include "engine/linalg/matrix_equations/decompositions.h"
#include "engine/linalg/matrix_equations/eigenvectors.h"
#include "engine/linalg/matrix_equations/lyapunov_equation.h"
#include "engine/linalg/matrix_equations/symmetric_lyapunov.h"

namespace stiefel {

template class Lyapunov<long double>;
template class SymmetricLyapunov<long double>;
template class SymmetricLyapunov<Quad>;

}  // namespace stiefel

template class Eigen::PartialPivLU<stiefel::Matrix<long double>>;
template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<long double>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<long double>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<long double>>&, int);
template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<long double>>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<long double>>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<std::complex<long double>>>&, int);
