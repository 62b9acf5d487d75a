#include "server/sessions/store/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <new>
#include <random>

#include "tests/support/folder.h"
#include "tests/server/store/stores.h"

namespace stiefel::server {
namespace {

using test::put;
using test::refusal;
using test::row;
using test::rows;
using testing::HasSubstr;

class StoreTest : public testing::Test {
 protected:
  test::Folder folder_;
  const std::string file_ = folder_.file();
};

TEST_F(StoreTest, GivesBackWhatItGot) {
  auto theirs = row("a", 70'000), plain = row("b", 0);
  theirs.principal.name = "alice";
  plain.choice.clear();
  {
    Store store(file_);
    put(store, row("a"));
    put(store, theirs);
    put(store, plain);
    store.transact([&] { store.put_checkpoint({}, "b", std::string("\0\1\2\xFF", 4)); });
    store.transact([&] { store.erase({}, "a"); });
    Database other(file_);
    EXPECT_EQ(other.text("PRAGMA journal_mode"), "wal");
    EXPECT_EQ(other.number("SELECT count(*) FROM session"), 2) << "a backup may read it";
  }
  struct stat status {};
  ASSERT_EQ(stat(file_.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  Store store(file_);
  const auto all = rows(store);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(StoredSession::columns(all.at("alice/a").session), StoredSession::columns(theirs));
  EXPECT_EQ(StoredSession::columns(all.at("/b").session), StoredSession::columns(plain));
  EXPECT_EQ(all.at("alice/a").checkpoint, "");
  EXPECT_EQ(all.at("/b").checkpoint, std::string("\0\1\2\xFF", 4));
}

TEST_F(StoreTest, ReplacingASessionRemovesItsCheckpoint) {
  Store store(file_);
  put(store, row("a", 5));
  store.transact([&] { store.put_checkpoint({}, "a", "state"); });
  EXPECT_EQ(rows(store).at("/a").checkpoint, "state");
  put(store, row("a", 9));
  EXPECT_EQ(rows(store).at("/a").session.scene.size(), 9u);
  EXPECT_EQ(rows(store).at("/a").checkpoint, "");
}

TEST_F(StoreTest, ATransactionThatThrowsChangesNothing) {
  Store store(file_);
  put(store, row("a"));
  EXPECT_THROW(store.transact([&] {
    store.put(row("b"));
    store.erase({}, "a");
    throw std::bad_alloc();
  }),
               std::bad_alloc);
  put(store, row("c"));
  EXPECT_EQ(rows(store).size(), 2u);
  EXPECT_TRUE(rows(store).contains("/a"));
}

TEST_F(StoreTest, KeepsTheLastTombstones) {
  constexpr std::int64_t most = Store::most_tombstones, beyond = 1000;
  {
    Store store(file_);
    store.transact([&] {
      for (std::int64_t i = 0; i < most + beyond; ++i)
        store.put(Tombstone{Principal{"p"}, std::to_string(i), i});
    });
  }
  Store store(file_);
  const auto all = store.tombstones(0), late = store.tombstones(most);
  ASSERT_EQ(all.size(), static_cast<std::size_t>(most));
  EXPECT_EQ(all.front().id, std::to_string(beyond));
  ASSERT_EQ(late.size(), static_cast<std::size_t>(beyond) - 1);
  EXPECT_EQ(late.front().principal.name, "p");
  EXPECT_EQ(late.front().until, most + 1);
}

TEST_F(StoreTest, ASecondServerIsRefused) {
  const Store store(file_);
  const std::string pid = std::to_string(getpid());
  EXPECT_EQ(refusal(file_), "the store " + file_ + ": in use by process " + pid);
  std::filesystem::create_symlink(file_, folder_.file("link"));
  EXPECT_THAT(refusal(folder_.file("link")), HasSubstr("in use by process " + pid));
}

TEST_F(StoreTest, WhatIsNoStoreIsRefused) {
  EXPECT_THAT(refusal(folder_.file("no/such/folder")), HasSubstr("No such file or directory"));
  std::filesystem::create_directory(folder_.file("folder"));
  EXPECT_THAT(refusal(folder_.file("folder")), HasSubstr("Is a directory"));
  test::write_file(folder_.file("text"), std::string(2000, 'x'));
  EXPECT_THAT(refusal(folder_.file("text")), HasSubstr("file is not a database"));
  { Store store(file_); }
  Database(file_).run("PRAGMA user_version=7");
  EXPECT_THAT(refusal(file_), HasSubstr("its schema version is 7, this server reads version 6"));
  Database(file_).run("PRAGMA application_id=7");
  EXPECT_THAT(refusal(file_), HasSubstr("of another program (application_id 7)"));
}

TEST_F(StoreTest, AStoreThatLostItsFileButNotItsLogIsRefused) {
  const std::string killed = folder_.file("killed");
  {
    Store store(file_);
    put(store, row("a"));
    // As a process leaves them that is killed.
    for (const char* suffix : {"", "-wal"}) std::filesystem::copy(file_ + suffix, killed + suffix);
  }
  std::filesystem::resize_file(killed, 0);
  EXPECT_THAT(refusal(killed), HasSubstr("restore a backup"));
  std::filesystem::remove(killed);
  EXPECT_THAT(refusal(killed), HasSubstr("restore a backup"));
  EXPECT_FALSE(std::filesystem::exists(killed));
  EXPECT_GT(std::filesystem::file_size(killed + "-wal"), 0u);
}

/// Opens copies of a store of 40 sessions that `damage` has changed. Each must be refused, and then
/// left alone, or have all sessions; returns how many are refused.
template <class Damage>
int refused_of(const test::Folder& folder, int copies, const Damage& damage) {
  const std::string whole_file = folder.file("whole"), file = folder.file("damaged");
  std::map<std::string, Store::Row> before;
  {
    Store store(whole_file);
    for (int i = 0; i < 40; ++i) put(store, row("s" + std::to_string(i), 50 * i * i));
    before = rows(store);
  }
  int refused = 0;
  for (int i = 0; i < copies; ++i) {
    std::string bytes = test::read_file(whole_file);
    damage(bytes);
    test::write_file(file, bytes);
    try {
      Store store(file);
      const auto after = rows(store);
      EXPECT_EQ(after.size(), before.size());
      for (const auto& [name, one] : after)
        EXPECT_EQ(StoredSession::columns(one.session),
                  StoredSession::columns(before.at(name).session));
    } catch (const std::runtime_error&) {
      ++refused;
      EXPECT_EQ(test::read_file(file), bytes);
    }
  }
  return refused;
}

TEST_F(StoreTest, CutAnywhereItIsRefusedOrWhole) {
  std::mt19937_64 random(1);
  const int refused = refused_of(folder_, 60, [&](std::string& bytes) {
    bytes.resize(std::uniform_int_distribution<std::size_t>(1, bytes.size() - 1)(random));
  });
  EXPECT_GT(refused, 55) << "a page is missing in almost all";
}

TEST_F(StoreTest, AChangedByteIsRefusedOrHarmless) {
  std::mt19937_64 random(2);
  const int refused = refused_of(folder_, 100, [&](std::string& bytes) {
    char& byte = bytes[std::uniform_int_distribution<std::size_t>(100, bytes.size() - 1)(random)];
    byte = static_cast<char>(byte ^ 0x10);
  });
  EXPECT_GT(refused, 50) << "most of the file is sessions";
}

/// What a change of the store is refused with, or "" if it is made.
std::string refused_change(Store& store) {
  try {
    put(store, row("a"));
    return "";
  } catch (const StoreError& error) {
    EXPECT_EQ(error.kind(), WriteFault::Kind::unavailable);
    EXPECT_EQ(error.what(), store.fault());
    return error.what();
  }
}

TEST_F(StoreTest, WithoutItsFilesItTakesNoChange) {
  const std::string elsewhere = folder_.file("elsewhere");
  Store store(file_);
  for (const std::string suffix : {"", "-wal", "-shm"}) {
    EXPECT_EQ(refused_change(store), "");
    std::filesystem::rename(file_ + suffix, elsewhere);
    EXPECT_THAT(refused_change(store), HasSubstr(file_ + suffix + " was removed"));
    test::write_file(file_ + suffix, test::read_file(elsewhere));
    EXPECT_THAT(refused_change(store), HasSubstr(file_ + suffix + " was replaced"));
    std::filesystem::rename(elsewhere, file_ + suffix);
    EXPECT_EQ(refused_change(store), "") << "the file is back";
  }
}

TEST_F(StoreTest, CheckFindsWhatOpeningWould) {
  EXPECT_FALSE(store_fault(""));
  EXPECT_FALSE(store_fault(file_)) << "it can be made";
  EXPECT_FALSE(std::filesystem::exists(file_)) << "and is not";
  EXPECT_THAT(store_fault(folder_.file("no/such/folder")).value_or(""),
              HasSubstr("No such file or directory"));
  {
    Store store(file_);
    put(store, row("a"));
    EXPECT_FALSE(store_fault(file_)) << "that of a server that runs";
  }
  EXPECT_FALSE(store_fault(file_));
  EXPECT_FALSE(std::filesystem::exists(file_ + "-wal")) << "it makes no file";
  std::filesystem::copy(file_, folder_.file("100%?#"));
  EXPECT_FALSE(store_fault(folder_.file("100%?#")));
  test::write_file(folder_.file("text"), std::string(2000, 'x'));
  EXPECT_THAT(store_fault(folder_.file("text")).value_or(""), HasSubstr("not a database"));
}

}  // namespace
}  // namespace stiefel::server
