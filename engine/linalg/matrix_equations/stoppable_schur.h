#pragma once

#include <Eigen/Eigenvalues>
#include <complex>

#include "engine/numbers/scalar.h"

/// Makes Eigen's Schur and Hessenberg decompositions stoppable (stiefel/stop.h), which take seconds
/// at N = 512. The Schur iterations check for a stop request in their test for small elements, the
/// reduction to Hessenberg form before every 16th column. The operations and their order are
/// Eigen's, so the bits are too. Include this header wherever one of these decompositions is used.
template <>
bool Eigen::ComplexSchur<stiefel::Matrix<std::complex<double>>>::subdiagonalEntryIsNeglegible(
    Index i);
template <>
bool Eigen::ComplexSchur<stiefel::Matrix<std::complex<long double>>>::subdiagonalEntryIsNeglegible(
    Index i);
template <>
Eigen::Index Eigen::RealSchur<stiefel::Matrix<double>>::findSmallSubdiagEntry(
    Index last, const double& considered_zero);
template <>
void Eigen::HessenbergDecomposition<stiefel::Matrix<std::complex<double>>>::_compute(
    stiefel::Matrix<std::complex<double>>& A, CoeffVectorType& coefficients, VectorType& workspace);
template <>
void Eigen::HessenbergDecomposition<stiefel::Matrix<double>>::_compute(
    stiefel::Matrix<double>& A, CoeffVectorType& coefficients, VectorType& workspace);
