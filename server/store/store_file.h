#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/store/file_lock.h"
#include "server/store/reserve.h"
#include "server/store/sqlite.h"
#include "server/store/store_options.h"

namespace stiefel::server {

/// The versions of the tables; `PRAGMA user_version` of the file.
inline constexpr std::int64_t schema_version = 1;
/// `PRAGMA application_id`: the bytes STFL.
inline constexpr std::int64_t application_id = 0x5354464C;

/// A store that is open, for this process alone. The log beside the file, FILE-wal, is written
/// through to the disk at every commit (synchronous=FULL).
struct StoreFile {
  FileLock lock;  // outlives the connection
  Reserve reserve;
  Database database;
};

/// Opens the store, or makes it where there is no file: then it appears whole or not at all. Reads
/// the whole file to find damage. Throws std::runtime_error with file and reason: another server
/// has it, another program's file, a newer version, damage, what the system refuses.
StoreFile open_store(const StoreOptions& options);

/// Why `open_store` would refuse a file that no server has open, as far as that shows without
/// reading all of it; changes nothing. A store that a server has open is in order.
std::optional<std::string> store_fault(const StoreOptions& options);

}  // namespace stiefel::server
