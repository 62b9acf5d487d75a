#pragma once

#include <expected>

#include "engine/linalg/arithmetic/scalar.h"
#include "stiefel/outside_domain.h"

namespace stiefel {

template <class T>
using WithinDomain = std::expected<T, OutsideDomain>;

/// The result of a correspondence: a matrix inside its domain, else an OutsideDomain.
template <class Scalar>
using MatrixWithin = WithinDomain<Matrix<Scalar>>;

}  // namespace stiefel
