#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "server/sessions/pending_write.h"

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

/// A connection to an SQLite file that exists. Statements wait up to 5 s for the locks of other
/// programs. For one thread at a time.
class Database {
 public:
  /// `immutable`: reads the file alone, without its log, and neither makes nor locks any file.
  /// Throws StoreError.
  explicit Database(const std::string& file, bool immutable = false);

  /// Runs statements without results.
  void run(const std::string& sql);
  /// Return the first column of the first row.
  std::int64_t number(const std::string& sql);
  std::string text(const std::string& sql);
  bool in_transaction() const;

 private:
  friend class Statement;
  [[noreturn]] void fail(int code) const;
  void check(int code) const;

  struct Close {
    void operator()(sqlite3* handle) const;
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement. Parameters are numbered from 1, columns from 0. The database must outlive
/// it.
class Statement {
 public:
  Statement(Database& database, std::string_view sql);

  /// Moves to the next row. Returns false after the last one, and makes the statement ready for the
  /// next parameters.
  bool step();
  /// Binds the parameters, each an integer or a text, and runs the statement to its end.
  template <class... Values>
  void execute(const Values&... values) {
    int parameter = 0;
    (bind(++parameter, values), ...);
    while (step()) continue;
  }

  void read(int column, std::int64_t& out) const;
  /// Reads a text or a blob; NULL is empty.
  void read(int column, std::string& out) const;

 private:
  void bind(int parameter, std::int64_t value);
  void bind(int parameter, std::string_view text);

  struct Finalize {
    void operator()(sqlite3_stmt* handle) const;
  };
  Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

}  // namespace stiefel::server
