#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

struct evp_md_ctx_st;

namespace stiefel::server {

/// 32 bytes: a SHA-256 digest, an HMAC-SHA256, a secret of 256 bits.
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

/// HMAC-SHA256 (RFC 2104) of the bytes. Throws std::runtime_error where OpenSSL fails.
Bytes32 hmac_sha256(const Bytes32& key, std::string_view bytes);

/// Returns 256 bits of OpenSSL's generator for secrets. Throws std::runtime_error where it fails.
Bytes32 random_secret();

/// Compares all 32 bytes in a time that does not depend on them.
bool equal_secrets(const Bytes32& a, const Bytes32& b);

/// Converts to 64 lower-case hexadecimal digits, and from digits of either case; returns nothing
/// for any other text.
std::string to_hexadecimal(const Bytes32& bytes);
std::optional<Bytes32> from_hexadecimal(std::string_view digits);

/// A line of a text file: its number, counted from 1, and its text without surrounding spaces.
struct Line {
  std::size_t number;
  std::string_view text;
};

/// Returns the lines that are neither empty nor begin with #, as views into `text`.
std::vector<Line> meaningful_lines(std::string_view text);

/// Removes the first word, up to a space or tab, from `text` and returns it.
std::string_view next_word(std::string_view& text);

/// A secret key for checkpoints, and the name that stands in each checkpoint and does not reveal
/// the key.
struct CheckpointKey {
  static constexpr std::size_t name_bytes = 8;

  explicit CheckpointKey(const Bytes32& secret);

  Bytes32 secret;
  std::string name;  ///< `name_bytes` bytes
};

/// The keys that authenticate checkpoints: the first signs, every one verifies. Immutable.
class CheckpointKeys {
 public:
  explicit CheckpointKeys(const std::vector<Bytes32>& secrets);

  /// Returns one random key for the whole process: no other server accepts its checkpoints.
  static std::shared_ptr<const CheckpointKeys> of_process();

  /// Parses the text of a key file: a key of 64 hexadecimal digits a line, the newest first;
  /// ignores empty lines and lines that begin with #. The error gives the line's number, never its
  /// text.
  static std::expected<CheckpointKeys, std::string> parse(std::string_view text);

  const CheckpointKey& signing() const { return keys_.front(); }
  /// Returns the key with that name; null if there is none.
  const CheckpointKey* find(std::string_view name) const {
    const auto found = std::ranges::find(keys_, name, &CheckpointKey::name);
    return found == keys_.end() ? nullptr : &*found;
  }

 private:
  std::vector<CheckpointKey> keys_;  // at least one
};

}  // namespace stiefel::server
