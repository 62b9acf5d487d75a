#pragma once

#include <sys/types.h>

#include <cstddef>
#include <vector>

namespace stiefel::server {

/// Counts connections whose descriptors somebody else owns and closes without a word. A descriptor
/// is still the connection that was added while it has the same inode: the kernel numbers sockets
/// one by one.
class OpenConnections {
 public:
  void add(int descriptor);
  /// How many there can be at most: some may have been closed since the last `prune`.
  std::size_t at_most() const { return open_.size(); }
  /// Forgets those that are closed; one fstat each.
  void prune();

 private:
  struct Open {
    int descriptor;
    ino_t inode;
  };
  std::vector<Open> open_;
};

}  // namespace stiefel::server
