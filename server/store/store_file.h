#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/store/file_lock.h"
#include "server/store/file_watch.h"
#include "server/store/reserve.h"
#include "server/store/sqlite.h"
#include "server/store/store_options.h"

namespace stiefel::server {

/// The version of the tables, in the file's `PRAGMA user_version`.
inline constexpr std::int64_t schema_version = 3;
/// The file's `PRAGMA application_id`: the bytes STFL.
inline constexpr std::int64_t application_id = 0x5354464C;

/// An open store, locked by this process under its name and, whatever name leads to it, the file
/// itself. Each commit writes the log beside it, FILE-wal, through to the disk (synchronous=FULL).
struct StoreFile {
  FileLock name_lock, lock;  // outlive the connection: to close the file drops SQLite's own locks
  Reserve reserve;
  Database database;
  FileWatch watch;  // of the file, its log and its index
};

/// Opens the store, or creates it if there is no file; a new file appears complete or not at all.
/// Reads the whole file to find damage. Throws std::runtime_error with the file and the reason:
/// another server has it, a second name (hard link), a size beyond the process's limit, another
/// program's file, a newer version, damage, or the system's error.
StoreFile open_store(const StoreOptions& options);

/// Returns why `open_store` would refuse a file that no server has open, as far as that shows
/// without reading all of it. Changes nothing. A store that a server has open is not a fault.
std::optional<std::string> store_fault(const StoreOptions& options);

}  // namespace stiefel::server
