#pragma once

#include <cstdint>
#include <string_view>

namespace stiefel::wire {

/// CRC-32C (RFC 3720, appendix B.4) of the bytes that follow those of which `before` is the
/// CRC-32C: crc32c(a + b) == crc32c(b, crc32c(a)). Of no bytes it is 0.
std::uint32_t crc32c(std::string_view bytes, std::uint32_t before = 0);

/// As `crc32c`, by tables: for processors without the instruction, and to test the other one.
std::uint32_t crc32c_by_tables(std::string_view bytes, std::uint32_t before = 0);

}  // namespace stiefel::wire
