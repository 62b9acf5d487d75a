#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "server/sessions/write_ahead_log.h"

struct sqlite3;
struct sqlite3_stmt;

namespace stiefel::server {

/// A failed call of SQLite, with SQLite's message.
class StoreError : public std::runtime_error {
 public:
  StoreError(WriteFault::Kind kind, const std::string& what)
      : std::runtime_error(what), kind_(kind) {}
  WriteFault::Kind kind() const { return kind_; }
  WriteFault fault() const { return {kind_, what()}; }

 private:
  WriteFault::Kind kind_;
};

/// A connection to an SQLite file. For one thread at a time.
class Database {
 public:
  enum class Mode { existing, create, read_only };
  /// `vfs` is SQLite's name of the file system to use, null for its default. Throws StoreError.
  Database(const std::string& file, Mode mode, const char* vfs = nullptr);
  ~Database();
  Database(Database&& other) noexcept;
  Database& operator=(Database&&) = delete;

  /// Runs statements without results.
  void run(const std::string& sql);
  /// Return the first column of the first row.
  std::int64_t number(const std::string& sql);
  std::string text(const std::string& sql);
  bool in_transaction() const;
  /// The longest time that a statement waits for the locks of other programs; at first 5 s.
  void set_patience(std::chrono::milliseconds patience);
  /// The number of rows that the last statement inserted or deleted.
  std::int64_t changes() const;

 private:
  friend class Statement;
  [[noreturn]] void fail(int code) const;
  void check(int code) const;

  sqlite3* handle_;
};

/// A prepared statement. Parameters are numbered from 1, columns from 0. Bound values must live
/// until the statement is reset, and the database must outlive it.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  /// NULL is bound where `value` is absent.
  Statement& bind(int parameter, std::int64_t value);
  Statement& bind(int parameter, std::string_view text);
  Statement& bind(int parameter, std::optional<double> value);
  struct Blob {
    std::string_view bytes;
  };
  Statement& bind(int parameter, Blob blob);

  /// Moves to the next row; returns false after the last one.
  bool step();
  /// Binds the parameters, runs the statement to its end and makes it ready for the next ones.
  template <class... Values>
  void execute(const Values&... values) {
    int parameter = 0;
    (bind(++parameter, values), ...);
    while (step()) continue;
    reset();
  }

  std::int64_t integer(int column) const;
  std::optional<double> real(int column) const;
  /// Returns a text or a blob.
  std::string bytes(int column) const;

 private:
  void reset();

  Database& database_;
  sqlite3_stmt* handle_ = nullptr;
};

}  // namespace stiefel::server
