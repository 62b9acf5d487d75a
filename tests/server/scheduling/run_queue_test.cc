// The order of jobs, without threads: the test takes each turn itself.
#include "server/scheduling/run_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <vector>

#include "tests/server/scheduling/scheduling.h"

namespace stiefel::server {
namespace {

using namespace std::chrono_literals;
constexpr double slice = short_work;
constexpr double endless = 1e30;

class RunQueueTest : public testing::Test {
 protected:
  /// A job, queued. With a price of 0 it is short.
  CountedJob& queue(Share& share, char name, int slices, double work, double price,
                    JobKind kind = JobKind::brief) {
    jobs_.push_back(std::make_unique<CountedJob>(name, slices, work, &order_));
    queue_.push(&jobs_.back()->of(share, price), kind);
    return *jobs_.back();
  }
  /// One turn of a worker; false if it has nothing to do.
  bool turn(JobKind most = JobKind::unsliced) {
    const RunQueue::Turn turn = queue_.pop(most);
    if (!turn.job) return false;
    const double before = work_done;
    const bool more = turn.job->run_slice();
    queue_.charge(turn, work_done - before, more);
    return true;
  }
  std::string order_;
  RunQueue queue_;
  std::vector<std::unique_ptr<CountedJob>> jobs_;
};

TEST_F(RunQueueTest, JobsOfAShareTakeTurns) {
  Share share;
  queue(share, 'a', 3, slice, endless);
  queue(share, 'b', 1, slice, endless, JobKind::unsliced);
  queue(share, 'c', 2, slice, endless, JobKind::sliced);
  while (turn()) {
  }
  EXPECT_EQ(order_, "abcaca");
}

TEST_F(RunQueueTest, WhatWaitsIsWhatIsLeftOfThePrices) {
  Share share;
  EXPECT_EQ(queue_.waiting_work(), 0U);
  queue(share, 'a', 2, slice, 3 * slice);
  queue(share, 'b', 1, slice, endless);
  const auto most = static_cast<std::uint64_t>(RunQueue::most_waiting);
  EXPECT_EQ(queue_.waiting_work(), 3 * 10'000'000U + most) << "no job counts for more than that";
  turn();
  EXPECT_EQ(queue_.waiting_work(), 2 * 10'000'000U + most) << "a slice less";
  while (turn()) {
  }
  EXPECT_EQ(queue_.waiting_work(), 0U);
}

TEST_F(RunQueueTest, AJobBeyondItsPriceHasASliceLeft) {
  Share share;
  queue(share, 'a', 3, 5 * slice, 4 * slice);
  turn();
  EXPECT_EQ(queue_.waiting_work(), 10'000'000U);
}

TEST_F(RunQueueTest, SharesAreEqualWhateverTheJobs) {
  Share greedy, modest, others;
  for (int i = 0; i < 50; ++i) queue(greedy, 'g', 1000, slice, endless);
  queue(modest, 'm', 1000, slice, endless);
  queue(others, 'o', 1000, 3 * slice, endless, JobKind::unsliced);  // longer slices, fewer of them
  for (int i = 0; i < 700; ++i) turn();
  std::map<char, int> slices;
  for (const char name : order_) ++slices[name];
  EXPECT_NEAR(slices['g'], 300, 5);
  EXPECT_NEAR(slices['m'], 300, 5);
  EXPECT_NEAR(slices['o'], 100, 5);
}

TEST_F(RunQueueTest, AShareThatComesLaterIsNotOwedThePast) {
  Share early, late;
  queue(early, 'e', 1000, slice, endless);
  for (int i = 0; i < 100; ++i) turn();
  queue(late, 'l', 1000, slice, endless);
  order_.clear();
  for (int i = 0; i < 20; ++i) turn();
  EXPECT_NEAR(static_cast<double>(std::ranges::count(order_, 'l')), 10, 1);
}

TEST_F(RunQueueTest, ALongJobIsMediumWhenLessIsLeft) {
  Share share;
  queue(share, 'a', 13, slice, 13 * slice);
  queue(share, 'b', 13, slice, 100 * slice);
  while (turn()) {
  }
  EXPECT_EQ(order_,
            "ababa"
            "aaaaaaaaa"
            "b"
            "a"
            "bbbbbbbbbb")
      << "the last ten slices of a job go before, but for one of the other after nine";
}

TEST_F(RunQueueTest, MediumJobsGoBeforeLongOnesAndAfterShortOnes) {
  Share busy, other;
  for (int i = 0; i < 10; ++i) queue(busy, 'l', 100, slice, endless);
  turn();
  queue(other, 'm', 2, slice, 2 * slice);
  queue(busy, 's', 1, slice / 10, slice / 10);
  queue(other, 'n', 1, slice, 3 * slice, JobKind::sliced);
  queue(other, 'x', 1, slice, 2 * slice, JobKind::unsliced);
  for (int i = 0; i < 4; ++i) turn(JobKind::brief);
  EXPECT_EQ(order_, "lsmmn") << "on a worker that reaches neither sliced jobs nor searches";
}

/// A principal whose calls just exceed a short one waits for a slice, not behind another's calls.
TEST_F(RunQueueTest, AMediumJobOfTheLeastServedShareIsNext) {
  Share busy, other;
  for (int i = 0; i < 64; ++i) queue(busy, 'l', 100, slice, 9 * slice);
  for (int i = 0; i < 30; ++i) {
    turn();
    queue(other, 'm', 1, slice / 2, 1.2 * slice);
    turn();
    EXPECT_EQ(order_.back(), 'm') << i;
  }
}

TEST_F(RunQueueTest, AFloodOfShortJobsDoesNotStarveMediumOnes) {
  Share flood, victim;
  queue(victim, 'v', 1000, slice / 2, 5 * slice);
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 4; ++k) queue(flood, 'f', 1, slice / 2, slice / 2);
    turn();
  }
  EXPECT_GT(std::ranges::count(order_, 'v'), 80);
}

TEST_F(RunQueueTest, AJobBeyondItsPriceIsLong) {
  Share share;
  queue(share, 'a', 6, slice, slice / 2);  // says that it is short
  queue(share, 'b', 3, slice, endless);
  while (turn()) {
  }
  EXPECT_EQ(order_.substr(0, 4), "aaba") << "short until it has taken what a short one may";
  EXPECT_EQ(order_.size(), 9u);
}

TEST_F(RunQueueTest, ShortJobsOfAShareDoNotStarveItsLongOnes) {
  Share share;
  queue(share, 'l', 1000, slice, endless);
  int longs = 0;
  for (int i = 0; i < 1000; ++i) {
    queue(share, 's', 1, slice / 2, slice / 2);
    turn();
    longs = static_cast<int>(std::ranges::count(order_, 'l'));
  }
  EXPECT_GE(longs, 40);
  EXPECT_LE(longs, 70) << "one slice after the work of eight";
}

TEST_F(RunQueueTest, AFloodOfShortJobsTakesNoMoreThanItsShare) {
  Share flood, victim;
  queue(victim, 'v', 100'000, slice, endless);
  for (int i = 0; i < 2000; ++i) {
    for (int k = 0; k < 4; ++k) queue(flood, 'f', 1, slice / 2, slice / 2);
    turn();
  }
  const auto work_of = [&](char name, double each) {
    return each * static_cast<double>(std::ranges::count(order_, name));
  };
  EXPECT_NEAR(work_of('v', 1) / work_of('f', 0.5), 1, 0.2);
}

TEST_F(RunQueueTest, AWorkerRunsOnlyWhatItReaches) {
  Share share;
  queue(share, 'w', 1, slice, endless, JobKind::unsliced);
  queue(share, 's', 1, slice, endless, JobKind::sliced);
  EXPECT_FALSE(turn(JobKind::brief));
  queue(share, 'b', 1, slice, endless, JobKind::brief);
  EXPECT_TRUE(turn(JobKind::brief));
  EXPECT_FALSE(turn(JobKind::brief));
  EXPECT_TRUE(turn(JobKind::sliced));
  EXPECT_FALSE(turn(JobKind::sliced));
  queue(share, 'x', 1, slice, 0, JobKind::unsliced);  // is never short
  queue(share, 'q', 1, slice, 0, JobKind::sliced);
  EXPECT_TRUE(turn(JobKind::brief));
  EXPECT_FALSE(turn(JobKind::brief));
  while (turn()) {
  }
  EXPECT_EQ(order_, "bsqwx");
}

TEST_F(RunQueueTest, OnlyAShareWithoutASearchIsNeglected) {
  Share greedy, first, second;
  queue(greedy, 'g', 1, slice, endless, JobKind::unsliced);
  const RunQueue::Turn search = queue_.pop(JobKind::unsliced);
  ASSERT_TRUE(search.job);
  queue(greedy, 'h', 1, slice, endless, JobKind::unsliced);
  queue(greedy, 's', 1, slice, 0);
  EXPECT_FALSE(queue_.pop_neglected().job) << "it has a search of its own";
  queue(first, 'a', 1, slice, endless, JobKind::unsliced);
  queue(first, 'b', 1, slice, endless, JobKind::unsliced);
  queue(second, 'c', 1, slice, endless, JobKind::sliced);
  std::vector<RunQueue::Turn> turns{queue_.pop_neglected(), queue_.pop_neglected()};
  ASSERT_TRUE(turns[0].job && turns[1].job);
  EXPECT_NE(turns[0].share, turns[1].share);
  EXPECT_FALSE(queue_.pop_neglected().job) << "one of each";
  for (const RunQueue::Turn& turn : turns) queue_.charge(turn, slice, false);
  const RunQueue::Turn next = queue_.pop_neglected();
  EXPECT_EQ(next.share, &first);
  queue_.charge(next, slice, false);
  queue_.charge(search, slice, false);
  EXPECT_EQ(queue_.pop_neglected().share, &greedy);
}

TEST_F(RunQueueTest, WhatIsTakenOutDoesNotRun) {
  Share share;
  CountedJob& a = queue(share, 'a', 1, slice, endless);
  CountedJob& b = queue(share, 'b', 1, slice, endless);
  CountedJob& c = queue(share, 'c', 1, slice, 0);
  EXPECT_TRUE(queue_.short_waits());
  queue_.remove(&c);
  EXPECT_FALSE(queue_.short_waits());
  EXPECT_TRUE(queue_.long_waits());
  queue_.remove(&a);
  EXPECT_FALSE(RunQueue::is_queued(&a));
  EXPECT_TRUE(RunQueue::is_queued(&b));
  while (turn()) {
  }
  EXPECT_EQ(order_, "b");
  EXPECT_TRUE(queue_.empty());
  EXPECT_FALSE(queue_.long_waits());
}

}  // namespace
}  // namespace stiefel::server
