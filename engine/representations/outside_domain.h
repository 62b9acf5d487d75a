#pragma once

#include <expected>
#include <string_view>

#include "engine/linalg/arithmetic/scalar.h"

namespace stiefel {

/// A correspondence asked for where it is not defined: the name of its domain in the papers ("S_M",
/// "S_L", ...), the number that decides, and the bound that the number should not have crossed.
struct OutsideDomain {
  std::string_view domain;
  double value;
  double bound;
};

template <class T>
using WithinDomain = std::expected<T, OutsideDomain>;

/// What a correspondence yields inside its domain.
template <class Scalar>
using MatrixWithin = WithinDomain<Matrix<Scalar>>;

}  // namespace stiefel
