#pragma once

#include <string_view>

namespace stiefel {

/// A correspondence asked for where it is not defined: the name of its domain in the papers ("S_M",
/// "S_L", ...), the number that decides, and the bound that the number should not have crossed.
struct OutsideDomain {
  std::string_view domain;
  double value;
  double bound;
};

}  // namespace stiefel
