#pragma once

#include <cstdint>
#include <string>

namespace stiefel::server {

struct StoreOptions {
  /// The file in which sessions are kept; empty means in memory only.
  std::string file = {};
  /// The largest size of the file in bytes; 0 means all that the disk has.
  std::uint64_t limit = 0;
  /// For tests: SQLite's name of the file system to use; null means its default.
  const char* vfs = nullptr;
};

}  // namespace stiefel::server
