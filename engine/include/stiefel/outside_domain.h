#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace stiefel {

/// The argument of a correspondence is outside its domain: the name of the domain in the papers
/// ("S_M", "S_L", ...), the number that decides, and its bound.
struct OutsideDomain {
  std::string_view domain;
  double value;
  double bound;
  std::optional<std::int64_t> member = {};  ///< of an ensemble
};

}  // namespace stiefel
