#pragma once

#include <cstdint>
#include <string>

namespace stiefel::server {

struct StoreOptions {
  /// Where sessions are kept; empty: in memory alone.
  std::string file = {};
  /// The largest size of the file in bytes; 0: as much as the disk has.
  std::uint64_t limit = 0;
  /// For tests: SQLite's name of the file system to use; null for its default.
  const char* vfs = nullptr;
};

}  // namespace stiefel::server
