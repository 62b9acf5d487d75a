#include "server/sessions/store/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "tests/server/store/folder.h"
#include "tests/server/store/one_store.h"

namespace stiefel::server {
namespace {

using test::put;
using test::refusal;
using test::session;
using testing::HasSubstr;

StoredCheckpoint checkpoint(const std::string& id, const std::string& numerics = "n") {
  return {Principal{}, id, numerics, 7, 123, std::string("\0\1\2\xFF", 4)};
}

/// What a store has, by principal and id.
std::map<std::string, Store::Row> rows(Store& store) {
  std::map<std::string, Store::Row> all;
  Store::Reader reader(store);
  while (auto row = reader.next())
    all.emplace(row->session.principal.name + "/" + row->session.id, *std::move(row));
  return all;
}

void expect_equal(const StoredSession& a, const StoredSession& b) {
  EXPECT_EQ(a.principal, b.principal);
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.create_time, b.create_time);
  EXPECT_EQ(a.numerics_id, b.numerics_id);
  EXPECT_EQ(a.identity, b.identity);
  EXPECT_EQ(a.scene, b.scene);
  EXPECT_EQ(a.filled_in, b.filled_in);
  EXPECT_EQ(a.cleared, b.cleared);
  ASSERT_EQ(a.choice.has_value(), b.choice.has_value());
  if (!a.choice) return;
  EXPECT_EQ(a.choice->tolerance, b.choice->tolerance);
  EXPECT_EQ(a.choice->horizon, b.choice->horizon);
  EXPECT_EQ(a.choice->reason, b.choice->reason);
  EXPECT_EQ(a.choice->error, b.choice->error);
  EXPECT_EQ(a.choice->verified, b.choice->verified);
}

class StoreTest : public testing::Test {
 protected:
  test::Folder folder_;
  const StoreOptions options_{folder_.file()};
};

TEST_F(StoreTest, GivesBackWhatItGot) {
  auto chosen = session("chosen", 70'000);
  chosen.choice = ChosenMethod{0.1, 1.0 / 3, "error 0.01, \0 work 3", 0.01, true};
  const auto plain = session("plain", 0);
  {
    Store store(options_);
    put(store, chosen);
    put(store, plain);
    store.transact([&] { store.put(checkpoint("plain")); });
  }
  Store store(options_);
  const auto all = rows(store);
  ASSERT_EQ(all.size(), 2u);
  expect_equal(all.at("/chosen").session, chosen);
  expect_equal(all.at("/plain").session, plain);
  EXPECT_FALSE(all.at("/chosen").checkpoint);
  ASSERT_TRUE(all.at("/plain").checkpoint);
  EXPECT_EQ(all.at("/plain").checkpoint->step, 123);
  EXPECT_EQ(all.at("/plain").checkpoint->state, checkpoint("plain").state);
}

TEST_F(StoreTest, OneIdOfTwoPrincipalsIsTwoSessions) {
  Store store(options_);
  auto theirs = session("a", 5);
  theirs.principal.name = "alice";
  put(store, theirs);
  put(store, session("a", 9));
  store.transact([&] { store.erase(Principal{}, "a"); });
  const auto all = rows(store);
  ASSERT_EQ(all.size(), 1u);
  expect_equal(all.at("alice/a").session, theirs);
}

TEST_F(StoreTest, ReplacingASessionRemovesItsCheckpoint) {
  Store store(options_);
  put(store, session("a", 5));
  store.transact([&] { store.put(checkpoint("a")); });
  put(store, session("a", 9));
  EXPECT_EQ(rows(store).at("/a").session.scene.size(), 9u);
  EXPECT_FALSE(rows(store).at("/a").checkpoint);
}

TEST_F(StoreTest, ATransactionThatThrowsChangesNothing) {
  Store store(options_);
  put(store, session("a"));
  EXPECT_THROW(store.transact([&] {
    store.put(session("b"));
    store.erase(Principal{}, "a");
    throw std::bad_alloc();
  }),
               std::bad_alloc);
  EXPECT_EQ(rows(store).size(), 1u);
  put(store, session("c"));
  EXPECT_EQ(rows(store).size(), 2u);
}

TEST_F(StoreTest, DropsCheckpointsOfOtherNumerics) {
  Store store(options_);
  for (const char* id : {"a", "b"}) put(store, session(id));
  store.transact([&] {
    store.put(checkpoint("a", "ours"));
    store.put(checkpoint("b", "theirs"));
    store.put(checkpoint("without a session", "ours"));
  });
  EXPECT_EQ(store.drop_checkpoints_except("ours"), 2);
  EXPECT_TRUE(rows(store).at("/a").checkpoint);
  EXPECT_FALSE(rows(store).at("/b").checkpoint);
}

TEST_F(StoreTest, KeepsDeletedNamesUntilTheirTime) {
  {
    Store store(options_);
    store.transact([&] {
      store.put(DeletedName{Principal{"p"}, "early", 10});
      store.put(DeletedName{Principal{"p"}, "late", 20});
      store.put(DeletedName{Principal{}, "later", 30});
      store.put(DeletedName{Principal{}, "again", 5});
      store.put(DeletedName{Principal{}, "again", 15});
    });
  }
  Store store(options_);
  const auto left = store.deleted_names(10);
  ASSERT_EQ(left.size(), 3u);
  EXPECT_EQ(left[0].id, "again");
  EXPECT_EQ(left[1].id, "late");
  EXPECT_EQ(left[1].principal.name, "p");
  EXPECT_EQ(left[1].until, 20);
  EXPECT_EQ(left[2].id, "later");
  EXPECT_EQ(store.deleted_names(0).size(), 4u) << "to look removes none";
  store.transact([&] { store.trim_deleted_names(20); });
  EXPECT_EQ(store.deleted_names(0).size(), 1u);
}

TEST_F(StoreTest, ThePrincipalWithMostDeletedNamesLosesItsOldest) {
  Store store(options_);
  constexpr std::int64_t most = Store::most_deleted_names, beyond = 1000, few = 10;
  store.transact([&] {
    for (std::int64_t i = 0; i < most + beyond; ++i)
      store.put(DeletedName{Principal{"many"}, std::to_string(i), 100 + i});
    for (std::int64_t i = 0; i < few; ++i)
      store.put(DeletedName{Principal{"few"}, std::to_string(i), 50 + i});
  });
  EXPECT_TRUE(store.deleted_names_pile_up());
  store.transact([&] { store.trim_deleted_names(0); });
  EXPECT_FALSE(store.deleted_names_pile_up());
  std::map<std::string, std::int64_t> counts;
  const auto left = store.deleted_names(0);
  for (const DeletedName& one : left) ++counts[one.principal.name];
  EXPECT_EQ(counts["few"], few) << "which are older than all others";
  EXPECT_EQ(counts["many"], most - few);
  EXPECT_EQ(left.back().until, 100 + most + beyond - 1);
}

TEST_F(StoreTest, ASecondServerIsRefused) {
  const Store store(options_);
  const std::string pid = std::to_string(getpid());
  EXPECT_EQ(refusal(options_), "the store " + options_.file + ": in use by process " + pid);
  std::filesystem::create_symlink(options_.file, folder_.file("link"));
  EXPECT_THAT(refusal({folder_.file("link")}), HasSubstr("in use by process " + pid));
}

TEST_F(StoreTest, ALargeDeletionNeedsLittleSpaceInTheLog) {
  Store store(options_);
  put(store, session("large", 8 << 20));
  Database(options_.file, Database::Mode::existing).run("PRAGMA wal_checkpoint(TRUNCATE)");
  store.transact([&] { store.erase(Principal{}, "large"); });
  EXPECT_LT(std::filesystem::file_size(options_.file + "-wal"), 200'000u);
  EXPECT_TRUE(rows(store).empty());
}

TEST_F(StoreTest, ANewerVersionIsRefused) {
  { Store store(options_); }
  Database(options_.file, Database::Mode::existing).run("PRAGMA user_version=5");
  EXPECT_THAT(refusal(options_), HasSubstr("its schema version is 5, this server reads version 4"));
}

TEST_F(StoreTest, WhatCannotBeAFileIsRefused) {
  EXPECT_THAT(refusal({folder_.file("no/such/folder")}), HasSubstr("No such file or directory"));
  std::filesystem::create_directory(folder_.file("folder"));
  EXPECT_THAT(refusal({folder_.file("folder")}), HasSubstr("it is not a regular file"));
  test::write_file(folder_.file("empty"), "");
  EXPECT_THAT(refusal({folder_.file("empty")}), HasSubstr("it is empty"));
}

TEST_F(StoreTest, AStoreThatLostItsFileButNotItsLogIsRefused) {
  {
    Store store(options_);
    put(store, session("a"));
    // As a process leaves them that is killed.
    for (const char* suffix : {"", "-wal"})
      std::filesystem::copy(options_.file + suffix, folder_.file("killed") + suffix);
  }
  const std::string killed = folder_.file("killed");
  std::filesystem::resize_file(killed, 0);
  EXPECT_THAT(refusal({killed}), HasSubstr("restore a backup"));
  std::filesystem::remove(killed);
  EXPECT_THAT(refusal({killed}), HasSubstr("restore a backup"));
  EXPECT_FALSE(std::filesystem::exists(killed));
}

TEST_F(StoreTest, ADraftOfAKilledServerIsInNobodysWay) {
  test::write_file(options_.file + "-new", "half a store");
  EXPECT_EQ(refusal(options_), "");
  EXPECT_FALSE(std::filesystem::exists(options_.file + "-new"));
}

TEST_F(StoreTest, CutAnywhereItIsRefusedOrWhole) {
  std::map<std::string, Store::Row> before;
  {
    Store store(options_);
    for (int i = 0; i < 40; ++i) put(store, session("s" + std::to_string(i), 50 * i * i));
    before = rows(store);
  }
  const std::string whole = test::read_file(options_.file);
  std::mt19937_64 random(1);
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    const std::string file = folder_.file("cut" + std::to_string(i));
    const auto size = std::uniform_int_distribution<std::size_t>(0, whole.size() - 1)(random);
    test::write_file(file, whole.substr(0, size));
    try {
      Store store({file});
      EXPECT_EQ(rows(store).size(), before.size()) << "cut to " << size;
    } catch (const std::runtime_error& error) {
      ++refused;
      EXPECT_THAT(error.what(), HasSubstr("the store " + file)) << "cut to " << size;
    }
    EXPECT_EQ(test::read_file(file), whole.substr(0, size)) << "a refused file is left alone";
  }
  EXPECT_GT(refused, 55) << "a page is missing in almost all";
}

TEST_F(StoreTest, AChangedByteIsRefusedOrHarmless) {
  std::map<std::string, Store::Row> before;
  {
    Store store(options_);
    for (int i = 0; i < 40; ++i) put(store, session("s" + std::to_string(i), 50 * i * i));
    before = rows(store);
  }
  const std::string whole = test::read_file(options_.file);
  std::mt19937_64 random(2);
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    const std::string file = folder_.file("changed");
    std::string bytes = whole;
    const auto at = std::uniform_int_distribution<std::size_t>(100, whole.size() - 1)(random);
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    test::write_file(file, bytes);
    try {
      Store store({file});
      const auto after = rows(store);
      ASSERT_EQ(after.size(), before.size()) << "byte " << at;
      for (const auto& [name, row] : before) expect_equal(after.at(name).session, row.session);
    } catch (const std::runtime_error& error) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 50) << "most of the file is sessions";
}

TEST_F(StoreTest, WhatIsBeyondTheLimitDoesNotFitAndTheRestStays) {
  Store store({folder_.file("small"), 200'000});
  put(store, session("fits", 50'000));
  try {
    put(store, session("does not", 200'000));
    FAIL();
  } catch (const StoreError& error) {
    EXPECT_EQ(error.kind(), WriteFault::Kind::full) << error.what();
  }
  EXPECT_EQ(rows(store).size(), 1u);
  store.transact([&] { store.erase(Principal{}, "fits"); });
  put(store, session("fits now", 100'000));
  EXPECT_EQ(rows(store).size(), 1u);
  EXPECT_LE(std::filesystem::file_size(folder_.file("small")), 200'000u);
}

TEST_F(StoreTest, CommitsAreWrittenThrough) {
  Store store(options_);
  put(store, session("a"));
  Database other(options_.file, Database::Mode::read_only);
  EXPECT_EQ(other.text("PRAGMA journal_mode"), "wal");
  EXPECT_EQ(other.number("SELECT count(*) FROM session"), 1) << "a backup may read it";
}

TEST_F(StoreTest, CheckFindsWhatOpeningWould) {
  EXPECT_FALSE(store_fault({}));
  EXPECT_FALSE(store_fault(options_)) << "it can be made";
  EXPECT_FALSE(std::filesystem::exists(options_.file)) << "and is not";
  EXPECT_THAT(store_fault({folder_.file("no/such/folder")}).value_or(""),
              HasSubstr("No such file or directory"));
  {
    Store store(options_);
    put(store, session("a"));
    EXPECT_FALSE(store_fault(options_)) << "that of a server that runs";
  }
  EXPECT_FALSE(store_fault(options_));
  test::write_file(folder_.file("text"), std::string(2000, 'x'));
  EXPECT_THAT(store_fault({folder_.file("text")}).value_or(""),
              HasSubstr("not an SQLite database"));
}

}  // namespace
}  // namespace stiefel::server
