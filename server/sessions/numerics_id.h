#pragma once

#include <string>

namespace stiefel::server {

/// A digest of all that may change the bits of a state (build_fingerprint), 16 hexadecimal digits.
/// Two servers with the same id compute the same states.
const std::string& numerics_id();

}  // namespace stiefel::server
