#include "server/sessions/store/store.h"

#include <bit>
#include <string_view>

#include "server/sessions/identity.h"

namespace stiefel::server {
namespace {

/// Collects columns, each text after its length, for the digest of a row.
class Digest {
 public:
  void add(std::int64_t value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(std::string_view text) {
    add(static_cast<std::int64_t>(text.size()));
    bytes_.append(text);
  }
  std::int64_t value() const { return std::bit_cast<std::int64_t>(hash(bytes_)); }

 private:
  std::string bytes_;
};

std::int64_t digest_of(const StoredSession& session) {
  Digest digest;
  std::apply([&](const auto&... columns) { (digest.add(columns), ...); },
             StoredSession::columns(session));
  return digest.value();
}

}  // namespace

Store::Store(const std::string& file)
    : file_(open_store(file)),
      put_session_(file_.database,
                   "INSERT OR REPLACE INTO session VALUES (?, ?, ?, ?, CAST(? AS BLOB), "
                   "CAST(? AS BLOB), CAST(? AS BLOB), ?)"),
      erase_session_(file_.database, "DELETE FROM session WHERE principal = ? AND id = ?"),
      put_checkpoint_(file_.database,
                      "INSERT OR REPLACE INTO checkpoint VALUES (?, ?, CAST(? AS BLOB))"),
      erase_checkpoint_(file_.database, "DELETE FROM checkpoint WHERE principal = ? AND id = ?"),
      put_tombstone_(file_.database,
                     "INSERT INTO tombstone (principal, id, until) VALUES (?, ?, ?)"),
      trim_tombstones_(file_.database,
                       "DELETE FROM tombstone WHERE number <= last_insert_rowid() - ?") {}

void Store::transact(const std::function<void()>& changes) {
  check_names();
  Database& database = file_.database;
  database.run("BEGIN IMMEDIATE");
  try {
    changes();
    database.run("COMMIT");
  } catch (...) {
    // After some errors SQLite has rolled back by itself.
    if (database.in_transaction()) {
      try {
        database.run("ROLLBACK");
      } catch (const StoreError&) {
      }
    }
    throw;
  }
  check_names();
}

void Store::put(const StoredSession& session) {
  std::apply([&](const auto&... columns) { put_session_.execute(columns..., digest_of(session)); },
             StoredSession::columns(session));
  erase_checkpoint_.execute(session.principal.name, session.id);
}

void Store::erase(const Principal& principal, const std::string& id) {
  erase_session_.execute(principal.name, id);
  erase_checkpoint_.execute(principal.name, id);
}

void Store::put_checkpoint(const Principal& principal, const std::string& id,
                           const std::string& bytes) {
  put_checkpoint_.execute(principal.name, id, bytes);
}

void Store::put(const Tombstone& tombstone) {
  put_tombstone_.execute(tombstone.principal.name, tombstone.id, tombstone.until);
  trim_tombstones_.execute(most_tombstones);
}

std::vector<Tombstone> Store::tombstones(std::int64_t now) {
  Statement all(file_.database, "SELECT principal, id, until FROM tombstone ORDER BY number");
  std::vector<Tombstone> tombstones;
  while (all.step()) {
    Tombstone one;
    all.read(2, one.until);
    if (one.until <= now) continue;
    all.read(0, one.principal.name);
    all.read(1, one.id);
    tombstones.push_back(std::move(one));
  }
  return tombstones;
}

Store::Reader::Reader(Store& store)
    : select_(store.file_.database,
              "SELECT session.*, bytes FROM session LEFT JOIN checkpoint USING (principal, id)") {}

std::optional<Store::Row> Store::Reader::next() {
  if (done_ || (done_ = !select_.step())) return std::nullopt;
  Row row{};
  int column = 0;
  std::apply([&](auto&... columns) { (select_.read(column++, columns), ...); },
             StoredSession::columns(row.session));
  std::int64_t digest = 0;
  select_.read(column++, digest);
  select_.read(column, row.checkpoint);
  if (digest_of(row.session) != digest)
    throw StoreError(WriteFault::Kind::damaged,
                     "the row of session '" + row.session.id + "' differs from its digest");
  return row;
}

}  // namespace stiefel::server
