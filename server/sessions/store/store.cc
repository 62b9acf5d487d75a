#include "server/sessions/store/store.h"

#include <algorithm>
#include <bit>

namespace stiefel::server {
namespace {

/// Collects columns, each text after its length, for the digest of a row.
class Digest {
 public:
  Digest& add(std::string_view text) {
    add(static_cast<std::int64_t>(text.size()));
    bytes_.append(text);
    return *this;
  }
  Digest& add(std::int64_t value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  std::int64_t value() const { return std::bit_cast<std::int64_t>(hash(bytes_)); }

 private:
  std::string bytes_;
};

std::int64_t digest_of(const StoredSession& s) {
  Digest digest;
  digest.add(s.principal.name).add(s.id).add(s.create_time).add(s.numerics_id);
  digest.add(std::bit_cast<std::int64_t>(s.identity)).add(s.scene).add(s.filled_in).add(s.cleared);
  if (s.choice) {
    digest.add(std::bit_cast<std::int64_t>(s.choice->tolerance));
    digest.add(std::bit_cast<std::int64_t>(s.choice->horizon)).add(s.choice->reason);
    digest.add(std::bit_cast<std::int64_t>(s.choice->error));
    digest.add(std::int64_t{s.choice->verified});
  }
  return digest.value();
}

std::int64_t digest_of(const StoredCheckpoint& c) {
  return Digest()
      .add(c.principal.name)
      .add(c.id)
      .add(c.numerics_id)
      .add(std::bit_cast<std::int64_t>(c.identity))
      .add(c.step)
      .add(c.state)
      .value();
}

/// Returns the place of a row. The upper bits of `hash` hardly differ for names that differ in
/// their last letters; those of the result (the finalizer of MurmurHash3) depend on all of its
/// bits.
std::int64_t place_of(const Principal& principal, std::string_view id) {
  auto bits = std::bit_cast<std::uint64_t>(Digest().add(principal.name).add(id).value());
  bits = (bits ^ bits >> 33) * 0xff51afd7ed558ccd;
  bits = (bits ^ bits >> 33) * 0xc4ceb9fe1a85ec53;
  return std::bit_cast<std::int64_t>(bits ^ bits >> 33);
}

constexpr std::string_view select =
    "SELECT principal, id, s.create_time, s.numerics_id, s.identity, s.scene, s.filled_in, "
    "s.cleared, s.tolerance, s.horizon, s.reason, s.error, s.verified, s.digest, c.numerics_id, "
    "c.identity, c.step, c.state, c.digest FROM session AS s LEFT JOIN checkpoint AS c USING "
    "(place, principal, id)";

/// Keeps the first rows of an order that begins with the newest deleted name of each principal and
/// goes on with the second newest of each.
constexpr std::string_view keep_newest =
    "DELETE FROM deleted_name WHERE (place, principal, id) IN (SELECT place, principal, id FROM "
    "(SELECT "
    "*, row_number() OVER (PARTITION BY principal ORDER BY until DESC) AS age FROM deleted_name) "
    "ORDER BY age LIMIT -1 OFFSET ?)";

}  // namespace

Store::Store(const StoreOptions& options)
    : file_(open_store(options)),
      put_session_(
          file_.database,
          "INSERT OR REPLACE INTO session VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"),
      erase_session_(file_.database,
                     "DELETE FROM session WHERE place = ? AND principal = ? AND id = ?"),
      put_checkpoint_(file_.database,
                      "INSERT OR REPLACE INTO checkpoint VALUES (?, ?, ?, ?, ?, ?, ?, ?)"),
      erase_checkpoint_(file_.database,
                        "DELETE FROM checkpoint WHERE place = ? AND principal = ? AND id = ?"),
      put_deleted_name_(file_.database, "INSERT OR REPLACE INTO deleted_name VALUES (?, ?, ?, ?)") {
}

void Store::transact(const std::function<void()>& changes, Patience wait) {
  check_names();
  Database& database = file_.database;
  database.set_patience(wait);
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

void Store::put(const StoredSession& s) {
  const auto& choice = s.choice;
  const auto number = [&](double ChosenMethod::*one) {
    return choice ? std::optional((*choice).*one) : std::nullopt;
  };
  put_session_.execute(
      place_of(s.principal, s.id), s.principal.name, s.id, s.create_time, s.numerics_id,
      std::bit_cast<std::int64_t>(s.identity), Statement::Blob{s.scene}, s.filled_in, s.cleared,
      number(&ChosenMethod::tolerance), number(&ChosenMethod::horizon),
      choice ? std::string_view(choice->reason) : std::string_view(), number(&ChosenMethod::error),
      std::int64_t{choice && choice->verified}, digest_of(s));
  erase_checkpoint_.execute(place_of(s.principal, s.id), s.principal.name, s.id);
}

void Store::erase(const Principal& principal, std::string_view id) {
  erase_session_.execute(place_of(principal, id), principal.name, id);
  erase_checkpoint_.execute(place_of(principal, id), principal.name, id);
}

void Store::put(const StoredCheckpoint& c) {
  put_checkpoint_.execute(place_of(c.principal, c.id), c.principal.name, c.id, c.numerics_id,
                          std::bit_cast<std::int64_t>(c.identity), c.step, Statement::Blob{c.state},
                          digest_of(c));
}

void Store::put(const DeletedName& deleted_name) {
  put_deleted_name_.execute(place_of(deleted_name.principal, deleted_name.id),
                            deleted_name.principal.name, deleted_name.id, deleted_name.until);
  ++since_trim_;
}

std::vector<DeletedName> Store::deleted_names(std::int64_t now) {
  Statement all(file_.database,
                "SELECT principal, id, until FROM deleted_name WHERE until > ? ORDER BY until");
  all.bind(1, now);
  std::vector<DeletedName> deleted_names;
  while (all.step())
    deleted_names.push_back({Principal{all.bytes(0)}, all.bytes(1), all.integer(2)});
  return deleted_names;
}

void Store::trim_deleted_names(std::int64_t now) {
  since_trim_ = 0;
  Statement(file_.database, "DELETE FROM deleted_name WHERE until <= ?").execute(now);
  if (file_.database.number("SELECT count(*) FROM deleted_name") > most_deleted_names)
    Statement(file_.database, keep_newest).execute(most_deleted_names);
}

std::int64_t Store::drop_checkpoints_except(std::string_view numerics_id) {
  Statement others(file_.database,
                   "DELETE FROM checkpoint WHERE numerics_id <> ? OR NOT EXISTS (SELECT 1 FROM "
                   "session AS s WHERE s.place = checkpoint.place AND s.principal = "
                   "checkpoint.principal AND s.id = "
                   "checkpoint.id)");
  others.execute(numerics_id);
  return file_.database.changes();
}

void Store::empty_log() noexcept {
  try {
    file_.database.run("PRAGMA wal_checkpoint(PASSIVE)");
  } catch (const std::exception&) {  // the disk is as full as before
  }
}

Store::Reader::Reader(Store& store) : select_(store.file_.database, select) {}

std::optional<Store::Row> Store::Reader::next() {
  if (!select_.step()) return std::nullopt;
  const Statement& row = select_;
  StoredSession s{Principal{row.bytes(0)},
                  row.bytes(1),
                  row.integer(2),
                  row.bytes(3),
                  std::bit_cast<std::uint64_t>(row.integer(4)),
                  row.bytes(5),
                  row.bytes(6),
                  row.bytes(7),
                  std::nullopt};
  if (const auto tolerance = row.real(8))
    s.choice = ChosenMethod{*tolerance, row.real(9).value_or(0), row.bytes(10),
                            row.real(11).value_or(0), row.integer(12) != 0};
  if (digest_of(s) != row.integer(13))
    throw StoreError(WriteFault::Kind::damaged,
                     "the row of session '" + s.id + "' differs from its digest");
  StoredCheckpoint c{s.principal,     s.id,
                     row.bytes(14),   std::bit_cast<std::uint64_t>(row.integer(15)),
                     row.integer(16), row.bytes(17)};
  if (c.numerics_id.empty() || digest_of(c) != row.integer(18))
    return Row{std::move(s), std::nullopt};
  return Row{std::move(s), std::move(c)};
}

}  // namespace stiefel::server
