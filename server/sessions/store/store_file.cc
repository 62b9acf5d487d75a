#include "server/sessions/store/store_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <utility>

namespace stiefel::server {
namespace {

/// Returns the process id that the holder wrote into the file.
std::string holder_of(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t count = pread(descriptor, text.data(), text.size(), 0);
  if (count <= 0) return "another process";
  return "process " + std::string(text.data(), static_cast<std::size_t>(count));
}

namespace fs = std::filesystem;

/// The pages in the log at which SQLite moves them into the file.
constexpr std::int64_t log_pages = 256;
/// The size in bytes to which SQLite cuts the log once its pages are in the file.
constexpr std::int64_t log_bytes = std::int64_t{4} << 20;

/// Rows lie in the order of their places, which is random: wherever rows were deleted, new ones
/// fill the pages again, whatever their names.
constexpr const char* tables = R"sql(
CREATE TABLE session (
  place INTEGER NOT NULL,        -- hash of principal and id
  principal TEXT NOT NULL,
  id TEXT NOT NULL,
  create_time INTEGER NOT NULL,  -- nanoseconds since 1970
  numerics_id TEXT NOT NULL,     -- of the server that wrote the row
  identity INTEGER NOT NULL,     -- hash of the resolved scene
  scene BLOB NOT NULL,           -- stiefel.v1.Scene, resolved
  filled_in TEXT NOT NULL,       -- paths of fields, one a line
  cleared TEXT NOT NULL,
  tolerance REAL,                -- what the method was chosen for, if it was
  horizon REAL,
  reason TEXT NOT NULL,
  error REAL,
  verified INTEGER NOT NULL,
  digest INTEGER NOT NULL,       -- hash of the columns above
  PRIMARY KEY (place, principal, id)
) STRICT, WITHOUT ROWID;
CREATE TABLE checkpoint (
  place INTEGER NOT NULL,
  principal TEXT NOT NULL,
  id TEXT NOT NULL,
  numerics_id TEXT NOT NULL,
  identity INTEGER NOT NULL,
  step INTEGER NOT NULL,
  state BLOB NOT NULL,           -- float64, little-endian
  digest INTEGER NOT NULL,
  PRIMARY KEY (place, principal, id)
) STRICT, WITHOUT ROWID;
CREATE TABLE deleted_name (
  place INTEGER NOT NULL,
  principal TEXT NOT NULL,
  id TEXT NOT NULL,
  until INTEGER NOT NULL,        -- nanoseconds since 1970
  PRIMARY KEY (place, principal, id)
) STRICT, WITHOUT ROWID;
)sql";

void sync_folder(const fs::path& folder) {
  const Descriptor opened(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened || fsync(opened.get()) != 0)
    throw std::runtime_error(folder.string() + ": " + std::strerror(errno));
}

/// Writes the new store under another name and renames it, so that a killed process leaves no
/// partial store.
void make_store(const fs::path& file, const char* vfs) {
  const std::string draft = file.string() + "-new";
  for (const char* suffix : {"", "-journal", "-wal", "-shm"}) fs::remove(draft + suffix);
  {
    Database database(draft, Database::Mode::create, vfs);
    database.run("PRAGMA synchronous=FULL");
    database.run("BEGIN");
    database.run(tables);
    database.run("PRAGMA application_id=" + std::to_string(application_id));
    database.run("PRAGMA user_version=" + std::to_string(schema_version));
    database.run("COMMIT");
  }
  fs::permissions(draft, fs::perms::owner_read | fs::perms::owner_write);
  fs::rename(draft, file);
  sync_folder(file.parent_path());
}

/// Returns four bytes of a file's header as a number, most significant byte first.
std::int64_t header_number(const std::string& header, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | static_cast<unsigned char>(header[offset + i]);
  return value;
}

/// Returns the file's header (sqlite.org/fileformat.html). Throws std::runtime_error if it has
/// none.
std::string header_of(const fs::path& file) {
  std::string header(100, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(std::strerror(errno));
  in.read(header.data(), static_cast<std::streamsize>(header.size()));
  if (!in || !header.starts_with("SQLite format 3"))
    throw std::runtime_error("it is not an SQLite database");
  return header;
}

/// Throws std::runtime_error unless the file's header is that of a store, so that no file of
/// another program is touched.
void check_header(const fs::path& file) {
  constexpr std::size_t user_version_at = 60, application_id_at = 68;
  const std::string header = header_of(file);
  const std::int64_t owner = header_number(header, application_id_at);
  if (owner != application_id)
    throw std::runtime_error("it is an SQLite file of another program (application_id " +
                             std::to_string(owner) + ")");
  const std::int64_t version = header_number(header, user_version_at);
  if (version != schema_version)
    throw std::runtime_error("its schema version is " + std::to_string(version) +
                             ", this server reads version " + std::to_string(schema_version));
}

void configure(Database& database, std::uint64_t limit) {
  if (const std::string mode = database.text("PRAGMA journal_mode=WAL"); mode != "wal")
    throw std::runtime_error("this file system allows no write-ahead log (journal mode " + mode +
                             ")");
  database.run("PRAGMA synchronous=FULL");
  database.run("PRAGMA mmap_size=0");
  // Debian's SQLite overwrites what is deleted: a deletion would need its bytes again in the log.
  database.run("PRAGMA secure_delete=OFF");
  database.run("PRAGMA temp_store=MEMORY");  // a container may have no folder for temporary files
  database.run("PRAGMA wal_autocheckpoint=" + std::to_string(log_pages));
  database.run("PRAGMA journal_size_limit=" + std::to_string(log_bytes));
  if (limit == 0) return;
  const auto page = static_cast<std::uint64_t>(database.number("PRAGMA page_size"));
  database.run("PRAGMA max_page_count=" + std::to_string(std::max<std::uint64_t>(limit / page, 1)));
}

void check_pages(Database& database) {
  if (const std::string fault = database.text("PRAGMA integrity_check(1)"); fault != "ok")
    throw StoreError(WriteFault::Kind::damaged, fault);
}

/// Throws std::runtime_error if the process may not write all of a file of this size.
void check_size_limit(std::uint64_t size) {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && size > limit.rlim_cur)
    throw std::runtime_error("it has " + std::to_string(size) +
                             " bytes, must have at most the process's limit of file sizes " +
                             "(ulimit -f), " + std::to_string(limit.rlim_cur));
}

/// Returns whether the store's file exists. Throws std::runtime_error if it is not a regular file,
/// is empty, has a second name, is larger than the process may write, or is absent although its log
/// has bytes.
bool checked_presence(const fs::path& file) {
  std::error_code ignored;
  const bool log = fs::file_size(file.string() + "-wal", ignored) > 0 && !ignored;
  const bool there = fs::exists(file);
  if (there && !fs::is_regular_file(file)) throw std::runtime_error("it is not a regular file");
  const bool empty = !there || fs::file_size(file) == 0;
  if (log && empty)
    throw std::runtime_error(
        "it is empty or absent, but its log, the file with -wal at the end, is not: restore a "
        "backup");
  if (there && empty)
    throw std::runtime_error("it is empty: restore a backup, or remove it to begin a new store");
  if (!there) return false;
  if (const auto names = fs::hard_link_count(file); names != 1)
    throw std::runtime_error("it has " + std::to_string(names) +
                             " names (hard links), must have 1: the log belongs to one name");
  check_size_limit(fs::file_size(file));
  return true;
}

/// Throws std::runtime_error unless the process may write the store's files that there are, and
/// make the others.
void check_rights(const fs::path& file) {
  for (const char* suffix : {"", "-lock", "-wal", "-shm"}) {
    const fs::path one = file.string() + suffix;
    const bool there = fs::exists(one);
    const fs::path& asked = there ? one : file.parent_path();
    if (access(asked.c_str(), there ? R_OK | W_OK : W_OK | X_OK) != 0)
      throw std::runtime_error(asked.string() + ": " + std::strerror(errno));
  }
}

/// Throws std::runtime_error if the disk has no room for SQLite's log and its index.
void check_space(const fs::path& file) {
  constexpr std::uintmax_t least = std::uintmax_t{1} << 20;
  if (const auto left = fs::space(file.parent_path()).available; left < least)
    throw std::runtime_error("there is no space: the disk has " + std::to_string(left) +
                             " bytes left, must have at least " + std::to_string(least));
}

StoreFile open_at(const fs::path& file, const StoreOptions& options) {
  FileLock name_lock(file.string() + "-lock", true);
  if (checked_presence(file)) check_header(file);
  if (!fs::exists(file)) make_store(file, options.vfs);
  FileLock lock(file, false);
  Database database(file.string(), Database::Mode::existing, options.vfs);
  configure(database, options.limit);
  check_pages(database);
  FileWatch watch({file, file.string() + "-wal", file.string() + "-shm"});
  return {std::move(name_lock), std::move(lock), std::move(database), std::move(watch)};
}

/// Returns the path of the file with its symbolic links resolved.
fs::path file_of(const StoreOptions& options) {
  return fs::weakly_canonical(fs::absolute(options.file));
}

/// Runs `work` and adds the name of the store to its errors.
template <class Work>
auto naming(const StoreOptions& options, const Work& work) {
  try {
    return work();
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error("the store " + options.file + ": " + error.code().message());
  } catch (const StoreError& error) {
    const bool damaged = error.kind() == WriteFault::Kind::damaged;
    throw std::runtime_error("the store " + options.file + (damaged ? " is damaged: " : ": ") +
                             error.what() + (damaged ? ": restore a backup" : ""));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("the store " + options.file + ": " + error.what());
  }
}

}  // namespace

FileLock::FileLock(const std::string& file, bool own)
    : file_(open(file.c_str(), O_RDWR | O_CLOEXEC | (own ? O_CREAT : 0), 0600)) {
  if (!file_) throw std::runtime_error(file + ": " + std::strerror(errno));
  if (flock(file_.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) throw std::runtime_error(file + ": " + std::strerror(errno));
    throw std::runtime_error("in use by " + (own ? holder_of(file_.get()) : "another process"));
  }
  if (!own) return;
  // The number serves the error message only; on a full disk the file stays empty.
  const std::string number = std::to_string(getpid());
  if (ftruncate(file_.get(), 0) == 0)
    static_cast<void>(pwrite(file_.get(), number.data(), number.size(), 0) > 0);
}

FileWatch::FileWatch(std::vector<std::string> names) {
  for (std::string& name : names) {
    struct stat now {};
    if (stat(name.c_str(), &now) != 0) throw std::runtime_error(name + ": " + std::strerror(errno));
    files_.push_back({std::move(name), now.st_dev, now.st_ino});
  }
  if (const auto wrong = fault()) throw std::runtime_error(*wrong);
}

std::optional<std::string> FileWatch::fault() const {
  for (const File& file : files_) {
    struct stat now {};
    if (stat(file.name.c_str(), &now) != 0)
      return file.name + " was removed or cannot be reached: " + std::strerror(errno) +
             ": restart the server";
    if (now.st_dev != file.device || now.st_ino != file.inode)
      return file.name + " was replaced by another file: restart the server";
    if (now.st_nlink != 1)
      return file.name + " has " + std::to_string(now.st_nlink) +
             " names (hard links), must have 1: remove the others";
  }
  return std::nullopt;
}

StoreFile open_store(const StoreOptions& options) {
  return naming(options, [&] { return open_at(file_of(options), options); });
}

std::optional<std::string> store_fault(const StoreOptions& options) {
  if (options.file.empty()) return std::nullopt;
  try {
    naming(options, [&] {
      const fs::path file = file_of(options);
      if (checked_presence(file)) check_header(file);
      check_rights(file);
      check_space(file);
    });
    return std::nullopt;
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace stiefel::server
