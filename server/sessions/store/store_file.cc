#include "server/sessions/store/store_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace stiefel::server {
namespace {

namespace fs = std::filesystem;

/// The pages in the log at which SQLite moves them into the file: until then they take the disk's
/// space twice.
constexpr int log_pages = 256;
/// The size in bytes to which SQLite cuts the log once its pages are in the file.
constexpr int log_bytes = 4 << 20;

/// Rows without an id of their own lie in the order of their keys. Ids of sessions are random, so
/// new rows fill the pages of deleted ones again.
constexpr const char* tables = R"sql(
CREATE TABLE session (
  principal TEXT NOT NULL,
  id TEXT NOT NULL,
  create_time INTEGER NOT NULL,  -- nanoseconds since 1970
  numerics_id TEXT NOT NULL,     -- of the server that wrote the row
  identity BLOB NOT NULL,        -- SHA-256 of the resolved scene
  scene BLOB NOT NULL,           -- stiefel.v1.Scene, resolved
  choice BLOB NOT NULL,          -- stiefel.v1.Choice, or empty
  digest INTEGER NOT NULL,       -- hash of the columns above
  PRIMARY KEY (principal, id)
) STRICT, WITHOUT ROWID;
CREATE TABLE checkpoint (
  principal TEXT NOT NULL,
  id TEXT NOT NULL,
  bytes BLOB NOT NULL,           -- as clients get them, with a digest
  PRIMARY KEY (principal, id)
) STRICT, WITHOUT ROWID;
CREATE TABLE tombstone (         -- of a deleted session
  number INTEGER PRIMARY KEY,    -- in the order of the deletions
  principal TEXT NOT NULL,
  id TEXT NOT NULL,
  until INTEGER NOT NULL         -- nanoseconds since 1970
) STRICT;
)sql";

[[noreturn]] void fail(const std::string& file) {
  throw std::runtime_error(file + ": " + std::strerror(errno));
}

/// Returns the process id that the holder of a lock wrote into the file.
std::string holder_of(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t count = pread(descriptor, text.data(), text.size(), 0);
  if (count <= 0) return "another process";
  return "process " + std::string(text.data(), static_cast<std::size_t>(count));
}

Descriptor locked(const std::string& file) {
  Descriptor lock(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!lock) fail(file);
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail(file);
    throw std::runtime_error("in use by " + holder_of(lock.get()));
  }
  // The number serves the error message only; on a full disk the file stays empty.
  const std::string number = std::to_string(getpid());
  if (ftruncate(lock.get(), 0) == 0)
    static_cast<void>(pwrite(lock.get(), number.data(), number.size(), 0) > 0);
  return lock;
}

/// Throws std::runtime_error if the file is absent or empty although its log has bytes, which
/// SQLite would remove.
void check_presence(const fs::path& file) {
  const auto size = [](const fs::path& path) {
    std::error_code absent;
    const std::uintmax_t bytes = fs::file_size(path, absent);
    return absent ? 0 : bytes;
  };
  if (size(file) == 0 && size(file.string() + "-wal") > 0)
    throw std::runtime_error(
        "it is empty or absent, but its log, the file with -wal at the end, is not: restore a "
        "backup");
}

/// Whether the database has no tables yet. Throws std::runtime_error if its tables are not those of
/// this version of the store.
bool is_new(Database& database) {
  if (database.number("SELECT count(*) FROM sqlite_schema") == 0) return true;
  const std::int64_t owner = database.number("PRAGMA application_id");
  if (owner != application_id)
    throw std::runtime_error("it is an SQLite file of another program (application_id " +
                             std::to_string(owner) + ")");
  const std::int64_t version = database.number("PRAGMA user_version");
  if (version != schema_version)
    throw std::runtime_error("its schema version is " + std::to_string(version) +
                             ", this server reads version " + std::to_string(schema_version));
  return false;
}

void configure(Database& database) {
  if (const std::string mode = database.text("PRAGMA journal_mode=WAL"); mode != "wal")
    throw std::runtime_error("this file system allows no write-ahead log (journal mode " + mode +
                             ")");
  database.run("PRAGMA synchronous=FULL");
  // Debian's SQLite overwrites what is deleted: a deletion would need its bytes again in the log.
  database.run("PRAGMA secure_delete=OFF");
  database.run("PRAGMA wal_autocheckpoint=" + std::to_string(log_pages));
  database.run("PRAGMA temp_store=MEMORY");  // a container may have no folder for temporary files
  database.run("PRAGMA journal_size_limit=" + std::to_string(log_bytes));
}

void make_tables(Database& database) {
  database.run("BEGIN");
  database.run(tables);
  database.run("PRAGMA application_id=" + std::to_string(application_id));
  database.run("PRAGMA user_version=" + std::to_string(schema_version));
  database.run("COMMIT");
}

/// Throws std::runtime_error unless the process may write the store's files that there are, and
/// make the others.
void check_rights(const fs::path& file) {
  for (const char* suffix : {"", "-lock", "-wal", "-shm"}) {
    const fs::path one = file.string() + suffix;
    const bool there = fs::exists(one);
    const fs::path& asked = there ? one : file.parent_path();
    if (access(asked.c_str(), there ? R_OK | W_OK : W_OK | X_OK) != 0) fail(asked.string());
  }
}

/// Throws std::runtime_error if the disk has no room for SQLite's log and its index.
void check_space(const fs::path& file) {
  constexpr std::uintmax_t least = std::uintmax_t{1} << 20;
  if (const auto left = fs::space(file.parent_path()).available; left < least)
    throw std::runtime_error("there is no space: the disk has " + std::to_string(left) +
                             " bytes left, must have at least " + std::to_string(least));
}

/// Calls `work` with the path of the file, its symbolic links resolved, and adds the name of the
/// store to its errors.
template <class Work>
auto with_path(const std::string& name, const Work& work) {
  const std::string store = "the store " + name;
  try {
    return work(fs::weakly_canonical(fs::absolute(name)));
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(store + ": " + error.code().message());
  } catch (const StoreError& error) {
    const bool damaged = error.kind() == WriteFault::Kind::damaged;
    throw std::runtime_error(store + (damaged ? " is damaged: " : ": ") + error.what() +
                             (damaged ? ": restore a backup" : ""));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(store + ": " + error.what());
  }
}

}  // namespace

FileWatch::FileWatch(std::vector<std::string> names) {
  for (std::string& name : names) {
    struct stat now {};
    if (stat(name.c_str(), &now) != 0) fail(name);
    files_.push_back({std::move(name), now.st_dev, now.st_ino});
  }
}

std::optional<std::string> FileWatch::fault() const {
  for (const File& file : files_) {
    struct stat now {};
    if (stat(file.name.c_str(), &now) != 0)
      return file.name + " was removed or cannot be reached: " + std::strerror(errno) +
             ": restart the server";
    if (now.st_dev != file.device || now.st_ino != file.inode)
      return file.name + " was replaced by another file: restart the server";
  }
  return std::nullopt;
}

StoreFile open_store(const std::string& name) {
  return with_path(name, [](const std::string& file) {
    Descriptor lock = locked(file + "-lock");
    check_presence(file);
    // SQLite would make a file that others may read.
    if (!Descriptor(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600))) fail(file);
    Database database(file);
    const bool empty = is_new(database);
    configure(database);
    if (empty) make_tables(database);
    if (const std::string fault = database.text("PRAGMA integrity_check(1)"); fault != "ok")
      throw StoreError(WriteFault::Kind::damaged, fault);
    FileWatch watch({file, file + "-wal", file + "-shm"});
    return StoreFile{std::move(lock), std::move(database), std::move(watch)};
  });
}

std::optional<std::string> store_fault(const std::string& name) {
  if (name.empty()) return std::nullopt;
  try {
    with_path(name, [](const fs::path& file) {
      check_presence(file);
      check_rights(file);
      check_space(file);
      if (!fs::exists(file)) return;
      Database database(file, true);
      is_new(database);
    });
    return std::nullopt;
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace stiefel::server
