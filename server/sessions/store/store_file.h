#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/scheduling/process.h"
#include "server/sessions/store/sqlite.h"

namespace stiefel::server {

struct StoreOptions {
  /// The file in which sessions are kept; empty means in memory only.
  std::string file = {};
  /// For tests: the largest size of the file in bytes; 0 means all that the disk has.
  std::uint64_t limit = 0;
  /// For tests: SQLite's name of the file system to use; null means its default.
  const char* vfs = nullptr;
};

/// Locks a file for this process with flock(2). The kernel releases the lock when the process ends,
/// in whatever way. The file stays.
class FileLock {
 public:
  /// `own`: creates the file if there is none, and writes this process's number into it. Throws
  /// std::runtime_error with the reason: "in use by process 123", or "by another process" where the
  /// number is not known.
  FileLock(const std::string& file, bool own);

 private:
  Descriptor file_;
};

/// Watches the names of files that SQLite has open: what is written into a file without a name is
/// lost when the process ends, and a file with a second name has a second log.
class FileWatch {
 public:
  /// The files that have these names now. Throws std::runtime_error if one is absent.
  explicit FileWatch(std::vector<std::string> names);

  /// Returns what is wrong: the name is gone or belongs to another file, or the file has further
  /// names.
  std::optional<std::string> fault() const;

 private:
  struct File {
    std::string name;
    dev_t device;
    ino_t inode;
  };
  std::vector<File> files_;
};

/// The version of the tables, in the file's `PRAGMA user_version`.
inline constexpr std::int64_t schema_version = 4;
/// The file's `PRAGMA application_id`: the bytes STFL.
inline constexpr std::int64_t application_id = 0x5354464C;

/// An open store, locked by this process under its name and, whatever name leads to it, the file
/// itself. Each commit writes the log beside it, FILE-wal, through to the disk (synchronous=FULL).
struct StoreFile {
  FileLock name_lock, lock;  // outlive the connection: to close the file drops SQLite's own locks
  Database database;
  FileWatch watch;  // of the file, its log and its index
};

/// Opens the store, or creates it if there is no file; a new file appears complete or not at all.
/// Reads the whole file to find damage. Throws std::runtime_error with the file and the reason:
/// another server has it, a second name (hard link), a size beyond the process's limit, another
/// program's file, a newer version, damage, or the system's error.
StoreFile open_store(const StoreOptions& options);

/// Returns why `open_store` would refuse a file that no server has open, as far as that shows
/// without reading all of it, or why the store would take no session: its file or its folder cannot
/// be written, or has no space. Changes nothing. A store that a server has open is not a fault.
std::optional<std::string> store_fault(const StoreOptions& options);

}  // namespace stiefel::server
