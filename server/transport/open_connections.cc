#include "server/transport/open_connections.h"

#include <sys/stat.h>

#include <optional>

namespace stiefel::server {
namespace {

std::optional<ino_t> inode_of(int descriptor) {
  struct stat found;
  if (fstat(descriptor, &found) != 0) return std::nullopt;
  return found.st_ino;
}

}  // namespace

void OpenConnections::add(int descriptor) {
  if (const auto inode = inode_of(descriptor)) open_.push_back({descriptor, *inode});
}

void OpenConnections::prune() {
  std::erase_if(open_, [](const Open& one) { return inode_of(one.descriptor) != one.inode; });
}

}  // namespace stiefel::server
