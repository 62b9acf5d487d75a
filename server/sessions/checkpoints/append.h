#pragma once

#include <cstdint>
#include <string>

#include "server/sessions/checkpoints/digest.h"

namespace stiefel::server {

/// Appends the eight bytes of a number, least significant first.
inline void append(std::string& bytes, std::uint64_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Appends a digest.
inline void append(std::string& bytes, const Bytes32& value) {
  bytes.append(reinterpret_cast<const char*>(value.data()), value.size());
}

}  // namespace stiefel::server
