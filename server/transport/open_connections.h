#pragma once

#include <sys/types.h>

#include <cstddef>
#include <vector>

namespace stiefel::server {

/// Counts connections whose descriptors another owner closes without notice. A descriptor is still
/// the connection that was added while its inode is the same, because the kernel gives every socket
/// a new one.
class OpenConnections {
 public:
  void add(int descriptor);
  /// The most connections that can be open; some may have been closed since the last `prune`.
  std::size_t at_most() const { return open_.size(); }
  /// Forgets the closed connections; costs one fstat each.
  void prune();

 private:
  struct Open {
    int descriptor;
    ino_t inode;
  };
  std::vector<Open> open_;
};

}  // namespace stiefel::server
