#pragma once

#include <expected>

#include "engine/numbers/scalar.h"
#include "stiefel/outside_domain.h"

namespace stiefel {

template <class T>
using WithinDomain = std::expected<T, OutsideDomain>;

/// The result of a correspondence: a matrix, or an OutsideDomain if the argument is outside its
/// domain.
template <class Scalar>
using MatrixWithin = WithinDomain<Matrix<Scalar>>;

}  // namespace stiefel
