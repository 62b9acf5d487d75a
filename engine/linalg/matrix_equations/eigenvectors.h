#pragma once

#include <Eigen/Eigenvalues>
#include <complex>

#include "engine/numbers/scalar.h"

/// Declares explicit instantiations of Eigen's eigensolver of symmetric and Hermitian matrices,
/// which takes seconds to compile; eigenvectors.cc compiles it once for each scalar. Callers must
/// pass a Matrix, because every other expression compiles the solver anew.
extern template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<double>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<double>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<double>>&, int);
extern template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<long double>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<long double>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<long double>>&, int);
extern template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<double>>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<double>>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<std::complex<double>>>&, int);
extern template Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<long double>>>&
Eigen::SelfAdjointEigenSolver<stiefel::Matrix<std::complex<long double>>>::compute(
    const Eigen::EigenBase<stiefel::Matrix<std::complex<long double>>>&, int);
