#include "server/scheduling/account.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;

TEST(Account, CallsAtOnce) {
  Accounts accounts({.calls = 2});
  Account &alice = accounts.of({"alice"}), &bob = accounts.of({"bob"});
  std::atomic<std::uint32_t> all = 0;
  EXPECT_FALSE(alice.enter_call(all));
  EXPECT_FALSE(alice.enter_call(all));
  const auto refusal = alice.enter_call(all);
  ASSERT_TRUE(refusal);
  EXPECT_STREQ(refusal->limit, "principal_calls");
  EXPECT_EQ(refusal->most, 2);
  EXPECT_EQ(refusal->asked, 3);
  EXPECT_GT(refusal->retry_after, 0ms);
  EXPECT_FALSE(bob.enter_call(all)) << "each has its own";
  EXPECT_EQ(all, 3U);
  all = most_calls;
  const auto full = bob.enter_call(all);
  ASSERT_TRUE(full);
  EXPECT_STREQ(full->limit, "calls");
  bob.leave_call(all);
  EXPECT_FALSE(bob.enter_call(all));
}

TEST(Account, ManyThreadsNeverHoldMoreThanTheLimit) {
  Accounts accounts({.calls = 3});
  std::atomic<std::uint32_t> all = 0;
  std::atomic<int> inside = 0, at_most = 0, taken = 0;
  std::vector<std::jthread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) {
        Account& account = accounts.of({"one"});
        if (account.enter_call(all)) continue;
        ++taken;
        const int now = ++inside;
        for (int seen = at_most; now > seen && !at_most.compare_exchange_weak(seen, now);) {
        }
        --inside;
        account.leave_call(all);
      }
    });
  }
  threads.clear();
  EXPECT_LE(at_most, 3);
  EXPECT_GT(taken, 0);
  EXPECT_EQ(all, 0U);
}

}  // namespace
}  // namespace stiefel::server
