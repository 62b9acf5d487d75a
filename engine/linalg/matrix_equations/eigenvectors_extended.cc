#include "engine/linalg/matrix_equations/eigenvectors.h"

template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<long double>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<long double>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<long double>>&, int);
template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<long double>>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<long double>>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<std::complex<long double>>>&, int);
