#include "tests/server/store/forgetful_vfs.h"

#include <sqlite3.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace stiefel::test {
namespace {

constexpr std::int64_t sector = 512;

ForgetfulVfs* current = nullptr;
sqlite3_vfs shim;
sqlite3_vfs& real() { return *static_cast<sqlite3_vfs*>(shim.pAppData); }

/// SQLite allocates it, with the real file behind it. `path` is null for temporary files, which
/// nobody reads after a crash.
struct File {
  sqlite3_file base;
  const char* path;
  sqlite3_file* behind() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

File& of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }

void write_at(std::string& bytes, std::int64_t offset, std::string_view data) {
  const auto end = static_cast<std::size_t>(offset) + data.size();
  if (bytes.size() < end) bytes.resize(end);
  bytes.replace(static_cast<std::size_t>(offset), data.size(), data);
}

int close_file(sqlite3_file* file) {
  return of(file).behind()->pMethods->xClose(of(file).behind());
}

int read_file(sqlite3_file* file, void* out, int count, sqlite3_int64 offset) {
  File& at = of(file);
  if (!at.path) return at.behind()->pMethods->xRead(at.behind(), out, count, offset);
  std::size_t got = 0;
  const bool alive = current->read(at.path, [&](const ForgetfulVfs::Content& content) {
    const auto from = static_cast<std::size_t>(offset);
    if (from < content.bytes.size())
      got = std::min(content.bytes.size() - from, static_cast<std::size_t>(count));
    std::memcpy(out, content.bytes.data() + (got ? from : 0), got);
  });
  if (!alive) return SQLITE_IOERR_READ;
  std::memset(static_cast<char*>(out) + got, 0, static_cast<std::size_t>(count) - got);
  return got == static_cast<std::size_t>(count) ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
}

int write_file(sqlite3_file* file, const void* data, int count, sqlite3_int64 offset) {
  File& at = of(file);
  if (!at.path) return at.behind()->pMethods->xWrite(at.behind(), data, count, offset);
  const std::string bytes(static_cast<const char*>(data), static_cast<std::size_t>(count));
  const bool alive = current->change(at.path, [&](ForgetfulVfs::Content& content) {
    write_at(content.bytes, offset, bytes);
    content.pending.push_back({offset, bytes, false});
    return true;
  });
  return alive ? SQLITE_OK : SQLITE_IOERR_WRITE;
}

int truncate_file(sqlite3_file* file, sqlite3_int64 size) {
  File& at = of(file);
  if (!at.path) return at.behind()->pMethods->xTruncate(at.behind(), size);
  const bool alive = current->change(at.path, [&](ForgetfulVfs::Content& content) {
    content.bytes.resize(static_cast<std::size_t>(size));
    content.pending.push_back({size, {}, true});
    return true;
  });
  return alive ? SQLITE_OK : SQLITE_IOERR_TRUNCATE;
}

int sync_file(sqlite3_file* file, int flags) {
  File& at = of(file);
  if (!at.path) return at.behind()->pMethods->xSync(at.behind(), flags);
  return current->synchronize(at.path) ? SQLITE_OK : SQLITE_IOERR_FSYNC;
}

int size_of_file(sqlite3_file* file, sqlite3_int64* size) {
  File& at = of(file);
  if (!at.path) return at.behind()->pMethods->xFileSize(at.behind(), size);
  const bool alive = current->read(at.path, [&](const ForgetfulVfs::Content& content) {
    *size = static_cast<sqlite3_int64>(content.bytes.size());
  });
  return alive ? SQLITE_OK : SQLITE_IOERR_FSTAT;
}

int lock(sqlite3_file* file, int level) {
  return of(file).behind()->pMethods->xLock(of(file).behind(), level);
}
int unlock(sqlite3_file* file, int level) {
  return of(file).behind()->pMethods->xUnlock(of(file).behind(), level);
}
int check_lock(sqlite3_file* file, int* out) {
  return of(file).behind()->pMethods->xCheckReservedLock(of(file).behind(), out);
}
/// Grows the file as SQLITE_FCNTL_SIZE_HINT asks.
int control(sqlite3_file* file, int operation, void* argument) {
  if (operation != SQLITE_FCNTL_SIZE_HINT || !of(file).path) return SQLITE_NOTFOUND;
  const auto asked = *static_cast<sqlite3_int64*>(argument);
  sqlite3_int64 size = 0;
  const int code = size_of_file(file, &size);
  return code == SQLITE_OK && asked > size ? truncate_file(file, asked) : code;
}
int sector_size(sqlite3_file*) { return sector; }
/// None: a write may be torn anywhere.
int characteristics(sqlite3_file*) { return 0; }
int map_shared(sqlite3_file* file, int page, int size, int extend, void volatile** out) {
  return of(file).behind()->pMethods->xShmMap(of(file).behind(), page, size, extend, out);
}
int lock_shared(sqlite3_file* file, int offset, int count, int flags) {
  return of(file).behind()->pMethods->xShmLock(of(file).behind(), offset, count, flags);
}
void shared_barrier(sqlite3_file* file) {
  of(file).behind()->pMethods->xShmBarrier(of(file).behind());
}
int unmap_shared(sqlite3_file* file, int remove) {
  return of(file).behind()->pMethods->xShmUnmap(of(file).behind(), remove);
}

const sqlite3_io_methods methods = {2,
                                    close_file,
                                    read_file,
                                    write_file,
                                    truncate_file,
                                    sync_file,
                                    size_of_file,
                                    lock,
                                    unlock,
                                    check_lock,
                                    control,
                                    sector_size,
                                    characteristics,
                                    map_shared,
                                    lock_shared,
                                    shared_barrier,
                                    unmap_shared,
                                    nullptr,
                                    nullptr};

int open_file(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* out_flags) {
  File& at = of(file);
  at.base.pMethods = nullptr;
  at.path = path;
  const int code = real().xOpen(&real(), path, at.behind(), flags, out_flags);
  if (code != SQLITE_OK) return code;
  if (path && !current->load(path)) {
    at.behind()->pMethods->xClose(at.behind());
    return SQLITE_CANTOPEN;
  }
  at.base.pMethods = &methods;
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs*, const char* path, int sync_folder) {
  bool alive = current->change(path, [](ForgetfulVfs::Content& content) {
    content = {};
    return true;
  });
  return alive ? real().xDelete(&real(), path, sync_folder) : SQLITE_IOERR_DELETE;
}

void write_whole(const std::string& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + path);
}

std::string read_whole(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

ForgetfulVfs::ForgetfulVfs() {
  if (current) throw std::logic_error("there is a ForgetfulVfs already");
  sqlite3_initialize();
  shim = *sqlite3_vfs_find(nullptr);
  shim.pAppData = sqlite3_vfs_find(nullptr);
  shim.zName = name;
  shim.pNext = nullptr;
  shim.szOsFile = static_cast<int>(sizeof(File)) + real().szOsFile;
  shim.xOpen = open_file;
  shim.xDelete = delete_file;
  current = this;
  sqlite3_vfs_register(&shim, 0);
}

ForgetfulVfs::~ForgetfulVfs() {
  sqlite3_vfs_unregister(&shim);
  current = nullptr;
}

void ForgetfulVfs::crash_at(std::int64_t n) {
  const std::lock_guard lock(mutex_);
  crash_at_ = n < 0 ? -1 : calls_ + n;
}

std::int64_t ForgetfulVfs::calls() const {
  const std::lock_guard lock(mutex_);
  return calls_;
}

bool ForgetfulVfs::crashed() const {
  const std::lock_guard lock(mutex_);
  return crashed_;
}

bool ForgetfulVfs::alive() {
  if (crash_at_ >= 0 && calls_ >= crash_at_) crashed_ = true;
  if (!crashed_) ++calls_;
  return !crashed_;
}

bool ForgetfulVfs::change(const std::string& path, const std::function<bool(Content&)>& use) {
  const std::lock_guard lock(mutex_);
  return alive() && use(files_[path]);
}

bool ForgetfulVfs::read(const std::string& path, const std::function<void(const Content&)>& use) {
  const std::lock_guard lock(mutex_);
  if (crashed_) return false;
  use(files_[path]);
  return true;
}

bool ForgetfulVfs::load(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (crashed_) return false;
  if (!files_.contains(path)) files_[path].bytes = read_whole(path);
  return true;
}

bool ForgetfulVfs::synchronize(const std::string& path) {
  const std::lock_guard lock(mutex_);
  if (!alive()) return false;
  Content& content = files_[path];
  content.pending.clear();
  write_whole(path, content.bytes);
  return true;
}

void ForgetfulVfs::restart(double kept, std::mt19937_64& random) {
  const std::lock_guard lock(mutex_);
  std::bernoulli_distribution keeps(kept);
  for (const auto& [path, content] : files_) {
    if (content.pending.empty() || !std::filesystem::exists(path)) continue;
    std::string disk = read_whole(path);
    for (const Write& write : content.pending) {
      const auto size = static_cast<std::int64_t>(write.bytes.size());
      if (write.truncate && keeps(random)) disk.resize(static_cast<std::size_t>(write.offset));
      for (std::int64_t at = 0; at < size;) {
        const std::int64_t part = std::min(size - at, sector - (write.offset + at) % sector);
        const auto bytes =
            std::string_view(write.bytes)
                .substr(static_cast<std::size_t>(at), static_cast<std::size_t>(part));
        if (keeps(random)) write_at(disk, write.offset + at, bytes);
        at += part;
      }
    }
    write_whole(path, disk);
  }
  files_.clear();
  crashed_ = false;
  crash_at_ = -1;
}

}  // namespace stiefel::test
