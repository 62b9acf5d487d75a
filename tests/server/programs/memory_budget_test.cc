// The budget of memory: what is taken before it is allocated, given up, given back; and its size.
#include "server/scheduling/memory_budget.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "server/scheduling/memory_limit.h"

namespace stiefel {
namespace {

using server::MemoryBudget;
using server::MemoryExhausted;
using server::MemoryLease;

constexpr std::uint64_t MiB = 1 << 20;

TEST(MemoryBudget, TakesWhatFitsAndGivesBack) {
  MemoryBudget budget(100);
  {
    const MemoryLease first(budget, 60);
    EXPECT_EQ(budget.used(), 60);
    EXPECT_FALSE(MemoryLease::if_it_fits(budget, 41));
    MemoryLease second(budget, 40);
    EXPECT_THROW(second.grow(1), MemoryExhausted);
    second.shrink(30);
    second.grow_to(20);
    EXPECT_EQ(second.bytes(), 20);
    MemoryLease moved = std::move(second);
    second = {};
    EXPECT_EQ(budget.used(), 80);
    moved = MemoryLease(budget, 5);
    EXPECT_EQ(budget.used(), 65);
    moved.shrink(1000);
    EXPECT_EQ(budget.used(), 60);
  }
  EXPECT_EQ(budget.used(), 0);
}

TEST(MemoryBudget, AMovedLeaseLeavesNoBudgetBehind) {
  MemoryBudget budget(100);
  MemoryLease first(budget, 60);
  MemoryLease second = std::move(first);
  EXPECT_TRUE(second);
  EXPECT_FALSE(first);
  first = std::move(second);
  EXPECT_TRUE(first);
  EXPECT_FALSE(second);
  EXPECT_EQ(first.bytes(), 60);
  EXPECT_EQ(budget.used(), 60);
}

TEST(MemoryBudget, SaysWhatItRefuses) {
  MemoryBudget budget(100);
  const MemoryLease held(budget, 70);
  try {
    const MemoryLease more(budget, 40);
    FAIL();
  } catch (const MemoryExhausted& refusal) {
    EXPECT_EQ(refusal.bytes(), 40);
    EXPECT_EQ(refusal.free(), 30);
    EXPECT_EQ(refusal.limit(), 100);
    EXPECT_TRUE(refusal.can_ever_fit());
  }
  try {
    const MemoryLease more(budget, 101);
    FAIL();
  } catch (const MemoryExhausted& refusal) {
    EXPECT_FALSE(refusal.can_ever_fit());
  }
}

TEST(MemoryBudget, GivesUpCachesFirst) {
  MemoryBudget budget(100);
  MemoryLease cache(budget, 90);
  int asked = 0;
  budget.reclaim_with([&](std::uint64_t) {
    ++asked;
    cache = {};
  });
  const MemoryLease needed(budget, 50);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(budget.used(), 50);
  EXPECT_THROW(MemoryLease(budget, 101), MemoryExhausted);
  EXPECT_EQ(asked, 1) << "what can never fit costs nobody a cache";
}

TEST(MemoryBudget, TakesWhatWasPromisedBeyondTheLimit) {
  MemoryBudget budget(100);
  MemoryLease cache(budget, 60);
  budget.reclaim_with([&](std::uint64_t) { cache = {}; });
  budget.allow_excess(true);
  MemoryLease first(budget, 80);
  EXPECT_EQ(budget.used(), 80) << "caches first";
  const MemoryLease second(budget, 80);
  EXPECT_EQ(budget.used(), 160);
  budget.allow_excess(false);
  EXPECT_THROW(MemoryLease(budget, 1), MemoryExhausted);
  EXPECT_FALSE(MemoryLease::if_it_fits(budget, 1));
  first = {};
  EXPECT_TRUE(MemoryLease::if_it_fits(budget, 20));
}

TEST(MemoryBudget, APartTakesFromTheWhole) {
  MemoryBudget whole(100);
  MemoryBudget part(60, whole, "part"), other(60, whole, "other");
  MemoryLease cache(part, 50);
  EXPECT_EQ(whole.used(), 50);
  try {
    const MemoryLease more(part, 20);
    FAIL();
  } catch (const MemoryExhausted& refusal) {
    EXPECT_STREQ(refusal.part(), "part");
    EXPECT_EQ(refusal.free(), 10);
    EXPECT_EQ(refusal.limit(), 60);
  }
  EXPECT_FALSE(MemoryLease::if_it_fits(part, 20));
  const MemoryLease others(other, 40);
  try {
    const MemoryLease more(other, 20);
    FAIL();
  } catch (const MemoryExhausted& refusal) {
    EXPECT_EQ(refusal.part(), nullptr) << "the whole has 10 left";
    EXPECT_EQ(refusal.free(), 10);
  }
  EXPECT_FALSE(MemoryLease::if_it_fits(other, 20));
  EXPECT_EQ(whole.used(), 90);
  EXPECT_EQ(other.used(), 40) << "what did not fit is not counted";
  int asked = 0;
  part.reclaim_with([&](std::uint64_t) {
    ++asked;
    cache = {};
  });
  { const MemoryLease needed(part, 20); }
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(whole.used(), 40);
  EXPECT_EQ(part.used(), 0);
}

TEST(MemoryBudget, IsNeverExceeded) {
  MemoryBudget budget(1000);
  std::atomic<bool> exceeded = false;
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int k = 0; k < 20'000; ++k) {
        const auto lease =
            MemoryLease::if_it_fits(budget, static_cast<std::uint64_t>(97 * t + k % 400));
        if (budget.used() > 1000) exceeded = true;
      }
    });
  threads.clear();
  EXPECT_FALSE(exceeded);
  EXPECT_EQ(budget.used(), 0);
}

TEST(MemoryLimit, ReadsBytes) {
  EXPECT_EQ(server::read_bytes("64M"), 64 * MiB);
  EXPECT_EQ(server::read_bytes("1.5G"), 1536 * MiB);
  EXPECT_EQ(server::read_bytes("1048576K"), 1024 * MiB);
  EXPECT_EQ(server::read_bytes("2T"), 2 * 1024 * 1024 * MiB);
  EXPECT_EQ(server::read_bytes("67108864"), 64 * MiB);
  for (const char* text : {"", "M", "63M", "-1G", "1g", "1GB", "1 G", " 1G", "0x10000000", "nan",
                           "inf", "nanG", "1e400", "2000000T", "1GG"})
    EXPECT_FALSE(server::read_bytes(text)) << text;
  EXPECT_EQ(server::read_bytes("0", 0), 0);
  EXPECT_EQ(server::read_bytes("63M", 0), 63 * MiB);
  EXPECT_FALSE(server::read_bytes("-1", 0));
}

/// A /proc and a /sys/fs/cgroup of its own.
class Groups : public testing::Test {
 protected:
  Groups() { write("proc/meminfo", "MemTotal:       16384 kB\nMemFree:  1 kB\n"); }
  ~Groups() override { std::filesystem::remove_all(root_); }
  void write(const std::string& path, const std::string& text) {
    std::filesystem::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  std::uint64_t available() const { return server::available_memory(root_); }

  const std::filesystem::path root_ =
      std::filesystem::temp_directory_path() / ("stiefel_groups_" + std::to_string(getpid()));
};

TEST_F(Groups, NoneButTheMachine) { EXPECT_EQ(available(), 16 * MiB); }

TEST_F(Groups, AndTheGroupsAbove) {
  write("proc/self/cgroup", "0::/a.slice/b.service\n");
  write("sys/fs/cgroup/a.slice/b.service/memory.max", "max\n");
  EXPECT_EQ(available(), 16 * MiB);
  write("sys/fs/cgroup/a.slice/memory.max", "5000000\n");
  EXPECT_EQ(available(), 5'000'000);
  write("sys/fs/cgroup/a.slice/b.service/memory.max", "4000000\n");
  EXPECT_EQ(available(), 4'000'000);
}

TEST_F(Groups, InAContainer) {
  write("proc/self/cgroup", "0::/\n");
  write("sys/fs/cgroup/memory.max", "3000000\n");
  EXPECT_EQ(available(), 3'000'000);
}

TEST(MemoryLimit, LargestMessage) {
  EXPECT_EQ(server::largest_message(256 * MiB), 16 * MiB);
  EXPECT_EQ(server::largest_message(1024 * 1024 * MiB), 256 * MiB);
}

}  // namespace
}  // namespace stiefel
