#include "server/sessions/store/store_writer.h"

#include <gtest/gtest.h>

#include <latch>
#include <thread>
#include <vector>

#include "tests/server/store/stores.h"
#include "tests/support/folder.h"

namespace stiefel::server {
namespace {

using test::row;

class StoreWriterTest : public testing::Test {
 protected:
  PendingWrite put(const std::string& id) {
    return writer_.submit([one = row(id)](Store& store) { store.put(one); },
                          [this](const WriteFault&) { ++faults_; });
  }

  test::Folder folder_;
  std::atomic<int> faults_ = 0;
  Store store_{folder_.file()};
  StoreWriter writer_{store_};
};

TEST_F(StoreWriterTest, ManyAtOnceAreOneTransaction) {
  std::latch first_is_written(1), all_are_there(1);
  const auto first = writer_.submit(
      [&](Store&) {
        first_is_written.count_down();
        all_are_there.wait();
      },
      {});
  first_is_written.wait();
  std::vector<PendingWrite> writes;
  {
    std::mutex mutex;
    std::vector<std::jthread> threads;
    for (int t = 0; t < 8; ++t)
      threads.emplace_back([&, t] {
        for (int i = 0; i < 50; ++i) {
          auto write = put(std::to_string(t) + "-" + std::to_string(i));
          const std::lock_guard lock(mutex);
          writes.push_back(std::move(write));
        }
      });
  }
  all_are_there.count_down();
  for (const PendingWrite& write : writes) EXPECT_FALSE(write.get());
  EXPECT_EQ(writer_.transactions(), 2u);
  Database other(folder_.file());
  EXPECT_EQ(other.number("SELECT count(*) FROM session"), 400) << "before the writer ends";
}

TEST_F(StoreWriterTest, WhatWaitsIsWrittenAtTheEnd) {
  const std::string file = folder_.file("other");
  {
    Store store(file);
    StoreWriter writer(store);
    for (const char* id : {"a", "b", "a"}) writer.submit([id](Store& to) { to.put(row(id)); }, {});
    writer.submit([](Store& to) { to.erase({}, "b"); }, {});
  }
  Store store(file);
  EXPECT_EQ(test::rows(store).size(), 1u);
}

TEST_F(StoreWriterTest, WhatCannotBeWrittenFailsAlone) {
  std::latch all_are_there(1);
  writer_.submit([&](Store&) { all_are_there.wait(); }, {});
  const auto before = put("before");
  const auto bad = writer_.submit([](Store&) { throw std::bad_alloc(); },
                                  [this](const WriteFault&) { ++faults_; });
  const auto after = put("after");
  all_are_there.count_down();
  ASSERT_TRUE(bad.get());
  EXPECT_EQ(bad.get()->kind, WriteFault::Kind::out_of_memory);
  EXPECT_FALSE(before.get());
  EXPECT_FALSE(after.get());
  EXPECT_EQ(faults_, 1);
}

TEST_F(StoreWriterTest, ALockOfAnotherProgramIsWaitedFor) {
  Database other(folder_.file());
  other.run("BEGIN IMMEDIATE");
  std::vector<PendingWrite> writes;
  for (int i = 0; i < 6; ++i) writes.push_back(put(std::to_string(i)));
  other.run("ROLLBACK");
  for (const PendingWrite& write : writes) EXPECT_FALSE(write.get());
  other.run("BEGIN IMMEDIATE");
  const auto late = put("late");
  EXPECT_EQ(late.get()->kind, WriteFault::Kind::locked) << "after 5 s";
  other.run("ROLLBACK");
  EXPECT_FALSE(put("after").get());
}

}  // namespace
}  // namespace stiefel::server
