#pragma once

#include <Eigen/Eigenvalues>
#include <complex>

#include "engine/linalg/arithmetic/scalar.h"

/// Eigen's Schur and Hessenberg decompositions take seconds at N = 512. Here they look at the stop
/// token (stiefel/stop.h): the Schur iterations in the test that each of them makes for small
/// elements, the reduction to Hessenberg form before every 16th column. The operations and their
/// order are Eigen's, so the bits are too. Include this header wherever one of them is used.
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
