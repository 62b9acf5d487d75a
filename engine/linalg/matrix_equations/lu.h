#pragma once

#include <Eigen/LU>

#include "engine/numbers/scalar.h"

/// Eigen's LU with partial pivoting, compiled once, in instances.cc.
extern template class Eigen::PartialPivLU<stiefel::Matrix<double>>;
extern template class Eigen::PartialPivLU<stiefel::Matrix<long double>>;
