#include "tests/server/store/forgetful_vfs.h"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/folder.h"

namespace stiefel::test {
namespace {

constexpr std::int64_t sector = 512;

struct Write {
  std::int64_t offset;
  std::string bytes;
  bool truncates;  ///< to `offset`
};
struct Content {
  std::string bytes;           ///< what a reader sees
  std::vector<Write> pending;  ///< since the last synchronization
};

std::mutex mutex;  // guards all of these
std::map<std::string, Content> files;
std::int64_t calls_left = -1;  // until the crash; -1: there is none
bool stopped = false;

sqlite3_vfs shim;
sqlite3_vfs* real = nullptr;

/// The path of a file lies behind the object of the real one.
const char*& path_of(sqlite3_file* file) {
  return *reinterpret_cast<const char**>(reinterpret_cast<char*>(file) + real->szOsFile);
}

/// Calls `use` with the content of a file; returns `fault` when the machine has stopped, which it
/// does at calls with `changes` only.
template <class Use>
int use_content(const char* path, bool changes, int fault, const Use& use) {
  const std::lock_guard lock(mutex);
  stopped = stopped || (changes && calls_left == 0);
  if (stopped) return fault;
  if (changes && calls_left > 0) --calls_left;
  return use(files[path]);
}

void write_at(std::string& bytes, std::int64_t offset, std::string_view data) {
  const auto begin = static_cast<std::size_t>(offset);
  if (bytes.size() < begin + data.size()) bytes.resize(begin + data.size());
  bytes.replace(begin, data.size(), data);
}

int read_file(sqlite3_file* file, void* out, int size, sqlite3_int64 offset) {
  return use_content(path_of(file), false, SQLITE_IOERR_READ, [&](const Content& content) {
    const auto from = std::min(static_cast<std::size_t>(offset), content.bytes.size());
    const auto count = static_cast<std::size_t>(size);
    const std::size_t got = content.bytes.copy(static_cast<char*>(out), count, from);
    std::memset(static_cast<char*>(out) + got, 0, count - got);
    return got == count ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
  });
}

int write_file(sqlite3_file* file, const void* data, int size, sqlite3_int64 offset) {
  return use_content(path_of(file), true, SQLITE_IOERR_WRITE, [&](Content& content) {
    const std::string bytes(static_cast<const char*>(data), static_cast<std::size_t>(size));
    write_at(content.bytes, offset, bytes);
    content.pending.push_back({offset, bytes, false});
    return SQLITE_OK;
  });
}

int truncate_file(sqlite3_file* file, sqlite3_int64 size) {
  return use_content(path_of(file), true, SQLITE_IOERR_TRUNCATE, [&](Content& content) {
    content.bytes.resize(static_cast<std::size_t>(size));
    content.pending.push_back({size, {}, true});
    return SQLITE_OK;
  });
}

int sync_file(sqlite3_file* file, int) {
  return use_content(path_of(file), true, SQLITE_IOERR_FSYNC, [&](Content& content) {
    content.pending.clear();
    test::write_file(path_of(file), content.bytes);
    return SQLITE_OK;
  });
}

int size_of_file(sqlite3_file* file, sqlite3_int64* size) {
  return use_content(path_of(file), false, SQLITE_IOERR_FSTAT, [&](const Content& content) {
    *size = static_cast<sqlite3_int64>(content.bytes.size());
    return SQLITE_OK;
  });
}

/// Returns the methods of a real file, with those for its content replaced.
const sqlite3_io_methods* methods_of(const sqlite3_io_methods* of_real) {
  static std::map<const sqlite3_io_methods*, sqlite3_io_methods> all;
  const std::lock_guard lock(mutex);
  sqlite3_io_methods& methods = all.try_emplace(of_real, *of_real).first->second;
  methods.iVersion = 2;  // no file in memory
  methods.xRead = read_file;
  methods.xWrite = write_file;
  methods.xTruncate = truncate_file;
  methods.xSync = sync_file;
  methods.xFileSize = size_of_file;
  methods.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
  methods.xSectorSize = [](sqlite3_file*) { return static_cast<int>(sector); };
  methods.xDeviceCharacteristics = [](sqlite3_file*) { return 0; };  // a write may be torn anywhere
  return &methods;
}

/// `path` is null for temporary files, which nobody reads after a crash.
int open_file(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* out_flags) {
  const int code = real->xOpen(real, path, file, flags, out_flags);
  if (code != SQLITE_OK || !path) return code;
  const int loaded = use_content(path, false, SQLITE_CANTOPEN, [&](Content& content) {
    if (content.bytes.empty() && content.pending.empty()) content.bytes = test::read_file(path);
    return SQLITE_OK;
  });
  if (loaded != SQLITE_OK) {
    file->pMethods->xClose(file);
    file->pMethods = nullptr;
    return loaded;
  }
  path_of(file) = path;
  file->pMethods = methods_of(file->pMethods);
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs*, const char* path, int sync_folder) {
  return use_content(path, true, SQLITE_IOERR_DELETE, [&](Content& content) {
    content = {};
    return real->xDelete(real, path, sync_folder);
  });
}

}  // namespace

ForgetfulVfs::ForgetfulVfs() {
  sqlite3_initialize();
  real = sqlite3_vfs_find(nullptr);
  shim = *real;
  shim.zName = "forgetful";
  shim.pNext = nullptr;
  shim.szOsFile = real->szOsFile + static_cast<int>(sizeof(const char*));
  shim.xOpen = open_file;
  shim.xDelete = delete_file;
  sqlite3_vfs_register(&shim, 1);
}

ForgetfulVfs::~ForgetfulVfs() {
  sqlite3_vfs_unregister(&shim);
  sqlite3_vfs_register(real, 1);
  files.clear();
  stopped = false;
  calls_left = -1;
}

void ForgetfulVfs::crash_at(std::int64_t n) {
  const std::lock_guard lock(mutex);
  calls_left = n;
}

bool ForgetfulVfs::crashed() const {
  const std::lock_guard lock(mutex);
  return stopped;
}

void ForgetfulVfs::restart(double kept, std::mt19937_64& random) {
  const std::lock_guard lock(mutex);
  std::bernoulli_distribution keeps(kept);
  for (const auto& [path, content] : files) {
    if (content.pending.empty() || !std::filesystem::exists(path)) continue;
    std::string disk = test::read_file(path);
    for (const Write& write : content.pending) {
      const auto size = static_cast<std::int64_t>(write.bytes.size());
      if (write.truncates && keeps(random)) disk.resize(static_cast<std::size_t>(write.offset));
      for (std::int64_t at = 0; at < size;) {
        const std::int64_t part = std::min(size - at, sector - (write.offset + at) % sector);
        const auto bytes =
            std::string_view(write.bytes)
                .substr(static_cast<std::size_t>(at), static_cast<std::size_t>(part));
        if (keeps(random)) write_at(disk, write.offset + at, bytes);
        at += part;
      }
    }
    test::write_file(path, disk);
  }
  files.clear();
  stopped = false;
  calls_left = -1;
}

}  // namespace stiefel::test
