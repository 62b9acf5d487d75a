#include "server/sessions/store/sqlite.h"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace stiefel::server {
namespace {

constexpr auto first_patience = std::chrono::seconds(5);

int flags_of(Database::Mode mode) {
  switch (mode) {
    case Database::Mode::existing:
      return SQLITE_OPEN_READWRITE;
    case Database::Mode::create:
      return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    case Database::Mode::read_only:
      return SQLITE_OPEN_READONLY;
  }
  std::unreachable();
}

/// Whether an error means a full disk, a process limit or a quota.
bool is_full(int error) { return error == ENOSPC || error == EDQUOT || error == EFBIG; }

/// Returns the system's error of a failed call. For a write to its log, SQLite notes the error with
/// the log's file only.
int system_error(sqlite3* database, int code) {
  int error = sqlite3_system_errno(database);
  sqlite3_file* log = nullptr;
  if (error == 0 && code == SQLITE_IOERR_WRITE &&
      sqlite3_file_control(database, nullptr, SQLITE_FCNTL_JOURNAL_POINTER, &log) == SQLITE_OK &&
      log && log->pMethods)
    log->pMethods->xFileControl(log, SQLITE_FCNTL_LAST_ERRNO, &error);
  return error;
}

WriteFault::Kind kind_of(int code, int system_error) {
  using Kind = WriteFault::Kind;
  switch (code & 0xFF) {
    case SQLITE_FULL:
    case SQLITE_TOOBIG:
      return Kind::full;
    case SQLITE_IOERR:
      return is_full(system_error) ? Kind::full : Kind::unavailable;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Kind::locked;
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_PROTOCOL:
      return Kind::unavailable;
    case SQLITE_NOMEM:
      return Kind::out_of_memory;
    default:
      return Kind::damaged;
  }
}

}  // namespace

Database::Database(const std::string& file, Mode mode, const char* vfs) {
  const int code =
      sqlite3_open_v2(file.c_str(), &handle_, flags_of(mode) | SQLITE_OPEN_NOMUTEX, vfs);
  if (code != SQLITE_OK) {
    const int error = handle_ ? sqlite3_system_errno(handle_) : 0;
    std::string what = handle_ ? sqlite3_errmsg(handle_) : sqlite3_errstr(code);
    if (error != 0) what += std::string(": ") + std::strerror(error);
    sqlite3_close_v2(handle_);
    throw StoreError(kind_of(code, error), what);
  }
  sqlite3_extended_result_codes(handle_, 1);
  set_patience(first_patience);
}

void Database::set_patience(std::chrono::milliseconds patience) {
  sqlite3_busy_timeout(handle_, static_cast<int>(patience.count()));
}

Database::~Database() { sqlite3_close_v2(handle_); }

Database::Database(Database&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}

void Database::fail(int code) const {
  const int error = system_error(handle_, code);
  std::string what = sqlite3_errmsg(handle_);
  if ((code & 0xFF) == SQLITE_IOERR && error != 0) what += std::string(": ") + std::strerror(error);
  throw StoreError(kind_of(code, error), what);
}

void Database::check(int code) const {
  if (code != SQLITE_OK) fail(code);
}

void Database::run(const std::string& sql) {
  check(sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr));
}

std::int64_t Database::number(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

std::string Database::text(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.bytes(0) : "";
}

bool Database::in_transaction() const { return sqlite3_get_autocommit(handle_) == 0; }

std::int64_t Database::changes() const { return sqlite3_changes64(handle_); }

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  database.check(sqlite3_prepare_v3(database.handle_, sql.data(), static_cast<int>(sql.size()),
                                    SQLITE_PREPARE_PERSISTENT, &handle_, nullptr));
}

Statement::~Statement() { sqlite3_finalize(handle_); }

Statement& Statement::bind(int parameter, std::int64_t value) {
  database_.check(sqlite3_bind_int64(handle_, parameter, value));
  return *this;
}

Statement& Statement::bind(int parameter, std::string_view text) {
  database_.check(sqlite3_bind_text64(handle_, parameter, text.empty() ? "" : text.data(),
                                      text.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(int parameter, Blob blob) {
  database_.check(sqlite3_bind_blob64(handle_, parameter,
                                      blob.bytes.empty() ? "" : blob.bytes.data(),
                                      blob.bytes.size(), SQLITE_STATIC));
  return *this;
}

Statement& Statement::bind(int parameter, std::optional<double> value) {
  database_.check(value ? sqlite3_bind_double(handle_, parameter, *value)
                        : sqlite3_bind_null(handle_, parameter));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) {
    try {
      database_.fail(code);
    } catch (const StoreError&) {
      sqlite3_reset(handle_);
      throw;
    }
  }
  return false;
}

void Statement::reset() { database_.check(sqlite3_reset(handle_)); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(handle_, column); }

std::optional<double> Statement::real(int column) const {
  if (sqlite3_column_type(handle_, column) == SQLITE_NULL) return std::nullopt;
  return sqlite3_column_double(handle_, column);
}

std::string Statement::bytes(int column) const {
  const void* data = sqlite3_column_blob(handle_, column);
  const int count = sqlite3_column_bytes(handle_, column);
  return data ? std::string(static_cast<const char*>(data), static_cast<std::size_t>(count)) : "";
}

}  // namespace stiefel::server
