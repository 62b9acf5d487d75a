#pragma once

#include <map>
#include <string>
#include <vector>

namespace stiefel {

/// A fault of a description: the path of the field ("initial.Q"), empty for the description as a
/// whole, its value and the rule that it breaks.
struct Violation {
  std::string field;
  std::string value;
  std::string rule;
  /// A constant in UPPER_SNAKE_CASE for faults that programs tell apart; `metadata` holds its
  /// numbers.
  std::string reason = {};
  std::map<std::string, std::string> metadata = {};

  bool operator==(const Violation&) const = default;
};
using Violations = std::vector<Violation>;

}  // namespace stiefel
