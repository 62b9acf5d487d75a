#pragma once

#include <compare>
#include <string>

namespace stiefel::server {

/// Who calls: sessions, quotas and shares belong to a principal. The name is empty for every caller
/// of a server without tokens.
struct Principal {
  std::string name;

  auto operator<=>(const Principal&) const = default;
};

}  // namespace stiefel::server
