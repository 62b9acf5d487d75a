#include "engine/linalg/matrix_equations/eigenvectors.h"

template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<double>>& Eigen::SelfAdjointEigenSolver<
    stiefel::Matrix<double>>::compute(const Eigen::EigenBase<stiefel::Matrix<double>>&, int);
template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<double>>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<double>>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<std::complex<double>>>&, int);
