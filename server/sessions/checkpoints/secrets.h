#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace stiefel::server {

/// 32 bytes: a SHA-256 digest, a secret of 256 bits.
using Bytes32 = std::array<unsigned char, 32>;

/// SHA-256 of the bytes. Throws std::runtime_error where OpenSSL fails.
Bytes32 sha256(std::string_view bytes);

/// SHA-256 of bytes that come in pieces. Throws std::runtime_error where OpenSSL fails.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// Returns the digest of all pieces added. No call may follow.
  Bytes32 digest();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// Returns 256 bits of OpenSSL's generator for secrets. Throws std::runtime_error where it fails.
Bytes32 random_secret();

/// Converts to 64 lower-case hexadecimal digits.
std::string to_hexadecimal(const Bytes32& bytes);

}  // namespace stiefel::server
