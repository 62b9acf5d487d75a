#pragma once

#include <expected>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/checkpoints/digest.h"

namespace stiefel::server {

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
  const CheckpointKey* find(std::string_view name) const;

 private:
  std::vector<CheckpointKey> keys_;  // at least one
};

}  // namespace stiefel::server
