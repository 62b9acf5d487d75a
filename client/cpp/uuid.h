#pragma once

#include <string>

namespace stiefel::client {

/// Returns a random UUID (version 4).
std::string make_uuid();

}  // namespace stiefel::client
