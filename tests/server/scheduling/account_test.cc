#include "server/scheduling/account.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;
using Kind = Permit::Kind;

TEST(Account, CallsAndStreamsAtOnce) {
  Accounts accounts({.streams = 1, .calls = 2});
  Account& account = accounts.of({"alice"});
  Permit first, second, third;
  EXPECT_FALSE(first.take(account, Kind::call, 1));
  EXPECT_FALSE(second.take(account, Kind::call, 1));
  const auto refusal = third.take(account, Kind::call, 1);
  ASSERT_TRUE(refusal);
  EXPECT_STREQ(refusal->limit, "principal_calls");
  EXPECT_EQ(refusal->most, 2);
  EXPECT_EQ(refusal->asked, 3);
  EXPECT_GT(refusal->retry_after, 0ms);
  EXPECT_FALSE(third.take(account, Kind::stream, 1)) << "a stream is not a call";
  EXPECT_FALSE(Permit().take(accounts.of({"bob"}), Kind::call, 1)) << "each has its own";
  const Permit moved = std::move(first);
  EXPECT_TRUE(first.take(account, Kind::call, 1)) << "the moved permit holds the place";
  second.give_back();
  second.give_back();
  EXPECT_FALSE(first.take(account, Kind::call, 1));
  EXPECT_TRUE(second.take(account, Kind::call, 1)) << "given back once";
}

TEST(Account, ACallThatCostsTooMuchNeverSucceeds) {
  Accounts accounts({.call_work = 1000});
  Permit permit;
  EXPECT_FALSE(permit.take(accounts.of({}), Kind::call, 1000));
  const auto refusal = permit.take(accounts.of({}), Kind::call, 1001);
  ASSERT_TRUE(refusal);
  EXPECT_STREQ(refusal->limit, "call_work");
  EXPECT_EQ(refusal->retry_after, 0ms);
}

TEST(Account, TheUseOfAllIsTheSum) {
  Accounts accounts({});
  Permit first, second;
  EXPECT_FALSE(first.take(accounts.of({}), Kind::call, 100));
  EXPECT_FALSE(second.take(accounts.of({"alice"}), Kind::stream, 20));
  accounts.of({"alice"}).pay(3);
  accounts.of({}).pay(4);
  EXPECT_EQ(accounts.use().admitted, 120U);
  EXPECT_EQ(accounts.use().paid, 7U);
  first.give_back();
  EXPECT_EQ(accounts.use().admitted, 20U);
}

TEST(Account, PermitsOfSessionsAreGivenBack) {
  Accounts accounts({.sessions = 1});
  Account& account = accounts.of({});
  Account::SessionPermit permit = account.admit_session().permit;
  EXPECT_TRUE(permit);
  const Account::SessionPermit copy = permit;
  permit.reset();
  const auto second = account.admit_session();
  EXPECT_FALSE(second.permit);
  ASSERT_TRUE(second.refusal);
  EXPECT_STREQ(second.refusal->limit, "principal_sessions");
}

TEST(Account, ARestoredSessionTakesAPermitBeyondTheQuota) {
  Accounts accounts({.sessions = 2});
  Account& account = accounts.of({});
  std::vector<Account::SessionPermit> permits;
  for (int i = 0; i < 3; ++i) permits.push_back(account.admit_restored_session());
  EXPECT_TRUE(account.admit_session().refusal);
  permits.pop_back();
  EXPECT_TRUE(account.admit_session().refusal) << "two are there still";
  permits.pop_back();
  EXPECT_FALSE(account.admit_session().refusal);
}

TEST(Account, MemoryIsThePrincipalsPartOfTheServers) {
  MemoryBudget whole(1000);
  std::vector<std::string> asked;
  Accounts accounts({.memory = 600}, whole, [&](const Principal& principal, std::uint64_t) {
    asked.push_back(principal.name);
  });
  MemoryBudget& alices = accounts.of({"alice"}).memory();
  const MemoryLease most(alices, 500);
  EXPECT_THROW(MemoryLease(alices, 200), MemoryExhausted);
  EXPECT_EQ(asked, std::vector<std::string>{"alice"}) << "her own caches and nobody else's";
  const MemoryLease bobs(accounts.of({"bob"}).memory(), 400);
  EXPECT_EQ(whole.used(), 900u);
  Accounts without({}, whole);
  EXPECT_EQ(&without.of({"alice"}).memory(), &whole);
}

TEST(Account, ManyThreadsNeverHoldMoreThanTheLimit) {
  Accounts accounts({.calls = 3});
  std::atomic<int> inside = 0, at_most = 0, taken = 0;
  std::vector<std::jthread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) {
        Account& account = accounts.of({"one"});
        Permit permit;
        if (permit.take(account, Kind::call, 1)) continue;
        ++taken;
        const int now = ++inside;
        for (int seen = at_most; now > seen && !at_most.compare_exchange_weak(seen, now);) {
        }
        --inside;
      }
    });
  }
  threads.clear();
  EXPECT_LE(at_most, 3);
  EXPECT_GT(taken, 0);
  EXPECT_FALSE(Permit().take(accounts.of({"one"}), Kind::call, 1));
}

}  // namespace
}  // namespace stiefel::server
