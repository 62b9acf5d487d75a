#pragma once

#include <cstdint>
#include <string_view>

namespace stiefel::wire {

/// Returns the CRC-32C (RFC 3720, appendix B.4) of `bytes`, 0 if there are none. `before` is the
/// CRC-32C of the bytes that precede them: crc32c(a + b) == crc32c(b, crc32c(a)).
std::uint32_t crc32c(std::string_view bytes, std::uint32_t before = 0);

/// Computes `crc32c` with tables, for processors without the instruction and for tests.
std::uint32_t crc32c_by_tables(std::string_view bytes, std::uint32_t before = 0);

}  // namespace stiefel::wire
