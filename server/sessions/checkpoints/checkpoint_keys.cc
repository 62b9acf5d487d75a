#include "server/sessions/checkpoints/checkpoint_keys.h"

#include <algorithm>

#include "server/sessions/checkpoints/lines.h"

namespace stiefel::server {

CheckpointKey::CheckpointKey(const Bytes32& bytes) : secret(bytes) {
  const Bytes32 mac = hmac_sha256(secret, "stiefel: name of a checkpoint key");
  name.assign(reinterpret_cast<const char*>(mac.data()), name_bytes);
}

CheckpointKeys::CheckpointKeys(const std::vector<Bytes32>& secrets)
    : keys_(secrets.begin(), secrets.end()) {}

std::shared_ptr<const CheckpointKeys> CheckpointKeys::of_process() {
  static const auto keys = std::make_shared<const CheckpointKeys>(std::vector{random_secret()});
  return keys;
}

std::expected<CheckpointKeys, std::string> CheckpointKeys::parse(std::string_view text) {
  std::vector<Bytes32> secrets;
  for (const Line& line : meaningful_lines(text)) {
    const auto secret = from_hexadecimal(line.text);
    if (!secret)
      return std::unexpected("line " + std::to_string(line.number) +
                             ": a key must be 64 hexadecimal digits");
    secrets.push_back(*secret);
  }
  if (secrets.empty()) return std::unexpected("there must be at least one key");
  return CheckpointKeys(secrets);
}

const CheckpointKey* CheckpointKeys::find(std::string_view name) const {
  const auto found = std::ranges::find(keys_, name, &CheckpointKey::name);
  return found == keys_.end() ? nullptr : &*found;
}

}  // namespace stiefel::server
