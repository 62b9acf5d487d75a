#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// 32 bytes: a SHA-256 digest, an HMAC-SHA256, a secret of 256 bits.
using Bytes32 = std::array<unsigned char, 32>;

/// SHA-256 of the bytes. Throws std::runtime_error where OpenSSL fails.
Bytes32 sha256(std::string_view bytes);

/// HMAC-SHA256 (RFC 2104) of the bytes. Throws std::runtime_error where OpenSSL fails.
Bytes32 hmac_sha256(const Bytes32& key, std::string_view bytes);

/// 256 bits of OpenSSL's generator for secrets. Throws std::runtime_error where it has none.
Bytes32 random_secret();

/// Compares all 32 bytes in a time that does not depend on them.
bool equal_secrets(const Bytes32& a, const Bytes32& b);

/// 64 lower-case hexadecimal digits, and back; nothing for what are no 64 hexadecimal digits.
std::string to_hexadecimal(const Bytes32& bytes);
std::optional<Bytes32> from_hexadecimal(std::string_view digits);

}  // namespace stiefel::server
