#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>

#include "engine/numbers/scalar.h"

// Eigen's decompositions, compiled once, in instances.cc and wide_precision.cc.
extern template class Eigen::PartialPivLU<stiefel::Matrix<double>>;
extern template class Eigen::PartialPivLU<stiefel::Matrix<long double>>;
extern template class Eigen::LLT<stiefel::Matrix<double>>;
extern template Eigen::Index Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(
    stiefel::Matrix<double>&);
extern template class Eigen::HouseholderQR<stiefel::Matrix<double>>;
extern template class Eigen::ColPivHouseholderQR<stiefel::Matrix<double>>;
