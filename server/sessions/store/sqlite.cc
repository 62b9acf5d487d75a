#include "server/sessions/store/sqlite.h"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>

namespace stiefel::server {
namespace {

constexpr int longest_wait = 5000;  // milliseconds

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

/// Returns the path as a part of a URI.
std::string escaped(const std::string& path) {
  std::string out;
  for (const char c : path)
    if (c == '%' || c == '?' || c == '#')
      out += c == '%' ? "%25" : c == '?' ? "%3f" : "%23";
    else
      out += c;
  return out;
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

void Database::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

Database::Database(const std::string& file, bool immutable) {
  const std::string name = immutable ? "file:" + escaped(file) + "?immutable=1" : file;
  const int mode = immutable ? SQLITE_OPEN_READONLY | SQLITE_OPEN_URI : SQLITE_OPEN_READWRITE;
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &opened, mode | SQLITE_OPEN_NOMUTEX, nullptr);
  handle_.reset(opened);
  if (!opened) throw StoreError(WriteFault::Kind::out_of_memory, sqlite3_errstr(code));
  check(code);
  sqlite3_extended_result_codes(opened, 1);
  sqlite3_busy_timeout(opened, longest_wait);
}

void Database::fail(int code) const {
  const int error = system_error(handle_.get(), code);
  std::string what = sqlite3_errmsg(handle_.get());
  const bool of_system = (code & 0xFF) == SQLITE_IOERR || (code & 0xFF) == SQLITE_CANTOPEN;
  if (of_system && error != 0) what += std::string(": ") + std::strerror(error);
  throw StoreError(kind_of(code, error), what);
}

void Database::check(int code) const {
  if (code != SQLITE_OK) fail(code);
}

void Database::run(const std::string& sql) {
  check(sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr));
}

std::int64_t Database::number(const std::string& sql) {
  Statement statement(*this, sql);
  std::int64_t value = 0;
  if (statement.step()) statement.read(0, value);
  return value;
}

std::string Database::text(const std::string& sql) {
  Statement statement(*this, sql);
  std::string value;
  if (statement.step()) statement.read(0, value);
  return value;
}

bool Database::in_transaction() const { return sqlite3_get_autocommit(handle_.get()) == 0; }

void Statement::Finalize::operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }

Statement::Statement(Database& database, std::string_view sql) : database_(database) {
  sqlite3_stmt* prepared = nullptr;
  const int code =
      sqlite3_prepare_v3(database.handle_.get(), sql.data(), static_cast<int>(sql.size()),
                         SQLITE_PREPARE_PERSISTENT, &prepared, nullptr);
  handle_.reset(prepared);
  database.check(code);
}

void Statement::bind(int parameter, std::int64_t value) {
  database_.check(sqlite3_bind_int64(handle_.get(), parameter, value));
}

void Statement::bind(int parameter, std::string_view text) {
  database_.check(sqlite3_bind_text64(handle_.get(), parameter, text.data(), text.size(),
                                      SQLITE_STATIC, SQLITE_UTF8));
}

bool Statement::step() {
  if (sqlite3_step(handle_.get()) == SQLITE_ROW) return true;
  database_.check(sqlite3_reset(handle_.get()));  // the error of the step, if it had one
  return false;
}

void Statement::read(int column, std::int64_t& out) const {
  out = sqlite3_column_int64(handle_.get(), column);
}

void Statement::read(int column, std::string& out) const {
  const void* data = sqlite3_column_blob(handle_.get(), column);
  const int count = sqlite3_column_bytes(handle_.get(), column);
  out.assign(data ? static_cast<const char*>(data) : "", static_cast<std::size_t>(count));
}

}  // namespace stiefel::server
