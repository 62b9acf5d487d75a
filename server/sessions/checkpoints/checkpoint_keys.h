#pragma once

#include <expected>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/sessions/checkpoints/digest.h"

namespace stiefel::server {

/// A key of checkpoints, with the name that stands in each checkpoint and does not tell the key.
struct CheckpointKey {
  static constexpr std::size_t name_bytes = 8;

  explicit CheckpointKey(const Bytes32& secret);

  Bytes32 secret;
  std::string name;  ///< `name_bytes` bytes
};

/// The keys that authenticate checkpoints: the first signs, all verify. Immutable.
class CheckpointKeys {
 public:
  explicit CheckpointKeys(const std::vector<Bytes32>& secrets);

  /// One random key for all of this process: no other server reads its checkpoints.
  static std::shared_ptr<const CheckpointKeys> of_process();

  /// Keys from a file's text: 64 hexadecimal digits a line, the new key first and old ones after
  /// it; empty lines and those that begin with # do not count. The error names the line and never
  /// shows it.
  static std::expected<CheckpointKeys, std::string> parse(std::string_view text);

  const CheckpointKey& signing() const { return keys_.front(); }
  /// The key of that name; null if there is none.
  const CheckpointKey* find(std::string_view name) const;

 private:
  std::vector<CheckpointKey> keys_;  // at least one
};

}  // namespace stiefel::server
