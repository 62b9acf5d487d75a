#pragma once

#include <Eigen/Eigenvalues>
#include <complex>

#include "engine/linalg/arithmetic/scalar.h"

/// Eigen's eigensolver of symmetric and Hermitian matrices, which takes seconds to compile: once
/// for each scalar, in eigenvectors.cc and eigenvectors_extended.cc. It is given a Matrix, because
/// it is compiled anew for every expression.
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
