#include "server/sessions/store/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <latch>
#include <thread>

#include "server/sessions/identity.h"
#include "tests/server/store/folder.h"
#include "tests/server/store/write_ahead_logs.h"

namespace stiefel::server {
namespace {

using test::everybody;

using namespace std::chrono_literals;
using test::outcome;
using test::Written;

class JournalTest : public testing::Test {
 protected:
  test::Folder folder_;
  const StoreOptions options_{folder_.file()};
};

TEST_F(JournalTest, WhatIsAcknowledgedIsInTheFile) {
  {
    Written written(options_);
    const auto a = written.create("a", 1), b = written.create("b", 2);
    EXPECT_FALSE(outcome(*a) || outcome(*b));
    EXPECT_FALSE(outcome(*written.registry.erase(everybody, "a").pending_write));
    Database other(options_.file, Database::Mode::read_only);
    EXPECT_EQ(other.text("SELECT id FROM session"), "b") << "before the server ends";
  }
  const auto stored = test::stored(options_.file);
  EXPECT_EQ(stored.size(), 1u);
  EXPECT_EQ(stored.at("b"), identity_of(test::numbered_scene(2).description()));
}

TEST_F(JournalTest, ASessionThatIsThereAlreadyWaitsForTheSameRow) {
  Written written(options_);
  const auto first = written.create("a"), again = written.create("a");
  EXPECT_EQ(first, again);
  EXPECT_FALSE(outcome(*again));
  EXPECT_EQ(written.create("a"), first) << "settled: nobody waits";
}

TEST_F(JournalTest, ManyAtOnceAreFewTransactions) {
  Written written(options_);
  constexpr int threads = 8, each = 250;
  std::atomic<int> acknowledged = 0;
  std::latch submitted(1), all(threads * each);
  // Holds the journal's thread in an acknowledgement, unless that comes before `then`, which calls
  // back on this thread.
  const auto here = std::this_thread::get_id();
  std::uint64_t first = 0;
  for (bool came_before = true; came_before; ++first) {
    came_before = false;
    written.create("first-" + std::to_string(first))->then([&](const auto&) {
      if (std::this_thread::get_id() == here)
        came_before = true;
      else
        submitted.wait();
    });
  }
  {
    std::vector<std::jthread> workers;
    for (int t = 0; t < threads; ++t)
      workers.emplace_back([&, t] {
        for (int i = 0; i < each; ++i)
          written.create(std::to_string(t) + "-" + std::to_string(i))->then([&](const auto& fault) {
            acknowledged += !fault;
            all.count_down();
          });
      });
  }
  submitted.count_down();
  all.wait();
  EXPECT_EQ(acknowledged, threads * each);
  EXPECT_LE(written.journal.transactions(), first + threads * each / Journal::max_changes + 1);
}

TEST_F(JournalTest, NamesOfManyThreadsEndAsTheRegistryHasThem) {
  std::map<std::string, std::string> expected;
  {
    Written written(options_);
    std::vector<std::jthread> workers;
    for (int t = 0; t < 4; ++t)
      workers.emplace_back([&, t] {
        for (int i = 0; i < 200; ++i) {
          const std::string id = std::to_string(i % 5);
          if ((i + t) % 3 == 0)
            written.registry.erase(everybody, id);
          else
            static_cast<void>(
                written.registry.create(everybody, id, test::numbered_scene(i + t), ""));
        }
      });
    workers.clear();
    for (const auto& session : written.registry.page(everybody, "", 10))
      expected[session->id()] = session->identity();
  }
  EXPECT_EQ(test::stored(options_.file), expected);
}

TEST_F(JournalTest, WhatDoesNotFitFailsAloneAndIsNoSession) {
  Written written({options_.file, 30'000});
  std::vector<std::pair<std::string, std::shared_ptr<PendingWrite>>> pending;
  for (int i = 0; i < 400; ++i) {
    const std::string id = "s" + std::to_string(i);
    pending.emplace_back(id, written.create(id, i));
  }
  int failed = 0;
  for (const auto& [id, pending_write] : pending) {
    const auto fault = outcome(*pending_write);
    failed += fault.has_value();
    EXPECT_TRUE(!fault || fault->kind == WriteFault::Kind::full) << id;
    EXPECT_EQ(written.registry.find(everybody, id).has_value(), !fault) << id;
  }
  EXPECT_GT(failed, 0);
  EXPECT_LT(failed, 400);
  EXPECT_FALSE(written.reports.empty());
  // Deletions make room: a page is free when its sessions are gone.
  for (int i = 0; i < 20; ++i)
    EXPECT_FALSE(
        outcome(*written.registry.erase(everybody, "s" + std::to_string(i)).pending_write));
  EXPECT_FALSE(outcome(*written.create("new", 1)));
}

TEST_F(JournalTest, ExpiredSessionsLeaveTheFile) {
  std::chrono::steady_clock::time_point now{};
  {
    Store store(options_);
    Registry registry(10, 1h, [&] { return now; });
    Journal journal(store, {test::identity_row, {}, {}});
    registry.write_to(journal);
    static_cast<void>(registry.create(everybody, "a", test::scene(), ""));
    now += 30min;
    static_cast<void>(registry.create(everybody, "b", test::scene(), ""));
    now += 30min;
    EXPECT_EQ(registry.expire(), 1u);
  }
  const auto stored = test::stored(options_.file);
  EXPECT_EQ(stored.size(), 1u);
  EXPECT_TRUE(stored.contains("b"));
}

TEST_F(JournalTest, DeletedNamesGoWithTheDeletion) {
  {
    Written written(options_);
    written.create("a");
    EXPECT_FALSE(outcome(*written.registry.erase(everybody, "a").pending_write));
    EXPECT_FALSE(outcome(*written.registry.erase(Principal{"p"}, "never there").pending_write));
  }
  Store store(options_);
  const auto deleted_names = store.deleted_names(0);
  ASSERT_EQ(deleted_names.size(), 2u);
  EXPECT_EQ(deleted_names[0].id, "a");
  EXPECT_EQ(deleted_names[1].principal.name, "p");
  const std::chrono::nanoseconds now(std::chrono::system_clock::now().time_since_epoch());
  EXPECT_NEAR(static_cast<double>(deleted_names[0].until - now.count()), 3600e9, 60e9)
      << "Written has an idle timeout of an hour";
}

TEST_F(JournalTest, AForeignLockIsWaitedForOnce) {
  using Clock = std::chrono::steady_clock;
  Written written(options_);
  Database other(options_.file, Database::Mode::existing);
  other.run("BEGIN IMMEDIATE");
  constexpr int count = 6;
  std::latch all(count);
  std::array<std::atomic<Clock::duration>, count> waited{};
  for (int i = 0; i < count; ++i) {
    const auto from = Clock::now();
    written.create(std::to_string(i), i)->then([&, i, from](const auto& fault) {
      EXPECT_TRUE(fault && fault->kind == WriteFault::Kind::locked) << i;
      waited[static_cast<std::size_t>(i)] = Clock::now() - from;
      all.count_down();
    });
    std::this_thread::sleep_for(200ms);  // so that they do not all lie in one transaction
  }
  all.wait();
  for (const auto& one : waited) {
    EXPECT_GE(one.load(), Store::patience - 100ms);
    EXPECT_LT(one.load(), 2 * Store::patience) << "six after each other take 30 s";
  }
  other.run("ROLLBACK");
  EXPECT_FALSE(outcome(*written.create("after", 1)));
}

TEST_F(JournalTest, ALockThatIsGivenBackDelaysOnly) {
  Written written(options_, 1ms);
  Database other(options_.file, Database::Mode::existing);
  other.run("BEGIN IMMEDIATE");
  std::vector<std::shared_ptr<PendingWrite>> pending;
  for (int i = 0; i < 6; ++i) pending.push_back(written.create(std::to_string(i), i));
  std::this_thread::sleep_for(300ms);
  other.run("ROLLBACK");
  for (const auto& pending_write : pending) EXPECT_FALSE(outcome(*pending_write));
}

/// A process whose files may have `bytes` bytes, as with `ulimit -f`.
class FileSizes {
 public:
  explicit FileSizes(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &now);
    handler_ = signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizes() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  sighandler_t handler_;
};

TEST_F(JournalTest, WhatDoesNotFitOnTheDiskIsRefusedAndLateSpaceIsUsed) {
  Written written(options_);
  std::vector<std::string> made;
  const auto create = [&](const std::string& id) {
    const auto fault = outcome(*written.create(id, static_cast<int>(made.size())));
    EXPECT_TRUE(!fault || fault->kind == WriteFault::Kind::full) << fault->what;
    if (!fault) made.push_back(id);
    return !fault;
  };
  {
    const FileSizes limited(100'000);
    while (create("a" + std::to_string(made.size()))) continue;
    EXPECT_GT(made.size(), 100u);
  }
  EXPECT_FALSE(outcome(*written.registry.erase(everybody, made.front()).pending_write));
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(create("b" + std::to_string(i)));
  Database other(options_.file, Database::Mode::read_only);
  EXPECT_EQ(other.number("SELECT count(*) FROM session"), std::ssize(made) - 1);
}

TEST_F(JournalTest, APendingWriteTellsLateAskersToo) {
  PendingWrite pending_write;
  int told = 0;
  pending_write.then([&](const auto& fault) { told += fault.has_value(); });
  EXPECT_EQ(told, 0);
  pending_write.settle(WriteFault{WriteFault::Kind::full, "full"});
  pending_write.then([&](const auto& fault) { told += fault->what == "full"; });
  EXPECT_EQ(told, 2);
}

}  // namespace
}  // namespace stiefel::server
