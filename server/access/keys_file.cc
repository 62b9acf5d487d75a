#include "server/access/keys_file.h"

#include <stdexcept>

#include "server/access/watched_files.h"

namespace stiefel::server {

std::shared_ptr<const CheckpointKeys> checkpoint_keys(const std::string& file) {
  if (file.empty()) return nullptr;
  const auto text = read_text(file);
  auto keys = text ? CheckpointKeys::parse(*text) : std::unexpected(text.error());
  if (!keys) throw std::runtime_error("--checkpoint-key: " + file + ": " + keys.error());
  return std::make_shared<const CheckpointKeys>(*std::move(keys));
}

}  // namespace stiefel::server
