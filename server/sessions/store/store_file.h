#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/scheduling/process.h"
#include "server/sessions/store/sqlite.h"

namespace stiefel::server {

/// The version of the tables, in the file's `PRAGMA user_version`.
inline constexpr std::int64_t schema_version = 6;
/// The file's `PRAGMA application_id`: the bytes STFL.
inline constexpr std::int64_t application_id = 0x5354464C;

/// Watches the names of files that SQLite has open: what is written into a file without a name is
/// lost when the process ends.
class FileWatch {
 public:
  /// The files that have these names now. Throws std::runtime_error if one is absent.
  explicit FileWatch(std::vector<std::string> names);

  /// Returns what is wrong: the name is gone or belongs to another file. Thread-safe.
  std::optional<std::string> fault() const;

 private:
  struct File {
    std::string name;
    dev_t device;
    ino_t inode;
  };
  std::vector<File> files_;
};

/// An open store. The process holds the lock FILE-lock (flock(2)), which the kernel releases when
/// the process ends, in whatever way. Each commit writes the log beside the file, FILE-wal, through
/// to the disk (synchronous=FULL).
struct StoreFile {
  Descriptor lock;
  Database database;
  FileWatch watch;  // of the file, its log and its index
};

/// Opens the store, or creates it if there is no file or an empty one. Reads the whole file to find
/// damage. Throws std::runtime_error with the file and the reason: another server has it, another
/// program's file, another version, damage, or the system's error.
StoreFile open_store(const std::string& name);

/// Returns why `open_store` would refuse a file that no server has open, as far as that shows
/// without reading all of it, or why the store would take no session: its file or its folder cannot
/// be written, or has no space. Changes nothing. A store that a server has open is not a fault; nor
/// is an empty name, which means no store.
std::optional<std::string> store_fault(const std::string& name);

}  // namespace stiefel::server
