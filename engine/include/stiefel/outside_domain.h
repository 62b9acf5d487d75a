#pragma once

#include <string>
#include <string_view>

namespace stiefel {

/// An argument is outside the domain of a correspondence: the domain's name in the papers ("S_M",
/// "S_L", ...), the value that was tested, and its bound.
struct OutsideDomain {
  std::string_view domain;
  double value;
  double bound;
  /// In a refusal of `convert`: the argument, as ConversionRefusal names it ("scene.initial.Q").
  std::string field = {};
};

}  // namespace stiefel
