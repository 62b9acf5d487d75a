// The parts of an ensemble that idle workers compute.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <latch>
#include <list>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/server/scene_cases.h"
#include "tests/server/scheduling/scheduling.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::server {
namespace {

/// What for_each_in_parallel does on a worker.
void share_out(std::size_t count, double nanoseconds,
               const std::function<void(std::size_t)>& item) {
  CrewOfThisThread::find()->run(
      count, nanoseconds,
      [](void* context, std::size_t i) {
        (*static_cast<const std::function<void(std::size_t)>*>(context))(i);
      },
      const_cast<std::function<void(std::size_t)>*>(&item));
}

TEST(Crew, EveryItemIsDoneOnce) {
  Scheduler scheduler(4);
  for (const std::size_t count : {1u, 2u, 3u, 100u, 10'000u}) {
    for (const double nanoseconds : {1.0, 1e6, 1e9}) {
      std::vector<std::atomic<int>> times(count);
      std::latch done(1);
      Calling job([&] {
        share_out(count, nanoseconds, [&](std::size_t i) { ++times[i]; });
        done.count_down();
        return false;
      });
      scheduler.submit(&job, JobKind::sliced);
      done.wait();
      EXPECT_TRUE(std::ranges::all_of(times, [](const auto& n) { return n == 1; })) << count;
    }
  }
}

/// The items wait for each other: they end only if idle workers take part. Of three workers one is
/// kept and does not help with items so long.
TEST(Crew, IdleWorkersHelp) {
  Scheduler scheduler(3);
  std::latch ready(1);
  Calling first([&] { return ready.count_down(), false; });
  scheduler.submit(&first, JobKind::unsliced);
  ready.wait();
  for (bool helped = false; !helped;) {  // a worker may not have gone to rest yet
    std::latch done(1);
    std::atomic<int> inside = 0;
    std::atomic<bool> together = false;
    Calling job([&] {
      share_out(2, 2e9, [&](std::size_t) {
        ++inside;
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
        while (!together && std::chrono::steady_clock::now() < end)
          if (inside == 2) together = true;
      });
      done.count_down();
      return false;
    });
    scheduler.submit(&job, JobKind::unsliced);
    done.wait();
    helped = together;
  }
}

/// The only worker that is not kept leads, and an extra one takes part in items that are too long
/// for the kept one. A short job that arrives while both are inside an item runs before these end.
TEST(Crew, AnExtraWorkerHelpsInPlaceOfTheKeptOne) {
  Scheduler scheduler(2);
  std::latch done(1), inside(2), ran(1);
  Calling brief([&] { return ran.count_down(), false; });
  Calling job([&] {
    share_out(2, 2e9, [&](std::size_t i) {
      inside.arrive_and_wait();
      if (i == 0) scheduler.submit(&brief, JobKind::brief);
      ran.wait();
    });
    done.count_down();
    return false;
  });
  scheduler.submit(&job, JobKind::unsliced);
  done.wait();
}

/// Every worker advances an ensemble at once, and there are never more at work than there are.
TEST(Crew, ThereAreNeverMoreThreadsThanTheBudget) {
  constexpr int threads = 3;
  std::atomic<int> working = 0, at_most = 0;
  {
    std::list<Calling> jobs;
    Scheduler scheduler(threads);
    for (int k = 0; k < 20; ++k) {
      jobs.emplace_back([&] {
        share_out(50, 1e7, [&](std::size_t) {
          const int now = ++working;
          for (int seen = at_most; now > seen && !at_most.compare_exchange_weak(seen, now);) {
          }
          std::this_thread::sleep_for(std::chrono::microseconds(20));
          --working;
        });
        return false;
      });
      scheduler.submit(&jobs.back(), JobKind::sliced);
    }
  }
  EXPECT_LE(at_most, threads);
  EXPECT_GE(at_most, 1);
}

TEST(Crew, AnEnsembleHasTheBitsThatItHasAlone) {
  std::vector<SceneDescription> scenes;
  for (unsigned b = 0; b < 40; ++b)
    scenes.push_back(testing::description(testing::RandomBody(5, b + 1), 0.05, "variational"));
  const Scene scene = Scene::resolve(testing::ensemble_of(scenes)).value();
  const auto alone = make_simulation(scene), shared = make_simulation(scene);
  ASSERT_TRUE(alone->advance(500).reached());
  Scheduler scheduler(4);
  std::latch done(1);
  Calling job([&, slices = 0]() mutable {
    EXPECT_TRUE(shared->advance(100).reached());
    if (++slices < 5) return true;
    done.count_down();
    return false;
  });
  scheduler.submit(&job, JobKind::sliced);
  done.wait();
  EXPECT_EQ(test::saved(*shared), test::saved(*alone));
}

/// Another principal's long job arrives while idle workers help: one of them turns to it between
/// two items. The leader ends only after that.
TEST(Crew, HelpersLeaveForAJobThatIsSubmitted) {
  Scheduler scheduler(3);
  Share mine, others;
  std::latch done(2);
  std::atomic<bool> begun = false, submitted = false;
  Calling other([&] { return begun = true, done.count_down(), false; });
  other.of(others, endless);
  Calling leader([&] {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!begun && std::chrono::steady_clock::now() < end)
      share_out(1000, 1e8, [&](std::size_t i) {
        std::this_thread::sleep_for(std::chrono::microseconds(10));
        if (i == 500 && !submitted.exchange(true)) scheduler.submit(&other, JobKind::unsliced);
      });
    EXPECT_TRUE(begun);
    done.count_down();
    return false;
  });
  leader.of(mine, endless);
  scheduler.submit(&leader, JobKind::unsliced);
  done.wait();
}

/// Two long jobs divide their work at once, and short jobs come between: each is done.
TEST(Crew, TwoLeadersAndShortJobsAllEnd) {
  for (const int threads : {1, 2, 3, 8}) {
    std::atomic<int> items = 0, shorts = 0;
    {
      std::list<Calling> jobs;
      Scheduler scheduler(threads);
      for (int k = 0; k < 2; ++k) {
        jobs.emplace_back([&, slices = 0]() mutable {
          for (int run = 0; run < 10; ++run) share_out(64, 1e6, [&](std::size_t) { ++items; });
          return ++slices < 10;
        });
        scheduler.submit(&jobs.back(), JobKind::unsliced);
      }
      for (int k = 0; k < 200; ++k) {
        jobs.emplace_back([&] { return ++shorts, false; });
        scheduler.submit(&jobs.back(), JobKind::brief);
      }
    }
    EXPECT_EQ(items, 2 * 10 * 10 * 64) << threads;
    EXPECT_EQ(shorts, 200) << threads;
  }
}

/// The work of helpers counts as the job's, in the share that it is billed to and in what the call
/// reads of it.
TEST(Crew, TheWorkOfHelpersIsTheJobs) {
  std::atomic<double> taken = 0;
  std::atomic<int> helped = 0;
  constexpr int items = 400;
  Scheduler scheduler(4, &counted_work);
  while (helped == 0) {  // a worker may not have gone to rest yet
    std::latch done(1);
    const double before = scheduler.work_done();
    taken = 0;
    Calling job([&] {
      const auto leader = std::this_thread::get_id();
      share_out(items, 1e8, [&](std::size_t) {
        std::this_thread::sleep_for(std::chrono::microseconds(20));
        work_done += 1;
        helped += std::this_thread::get_id() != leader;
      });
      taken = take_slice_work();
      done.count_down();
      return false;
    });
    scheduler.submit(&job, JobKind::sliced);
    done.wait();
    EXPECT_EQ(taken, items);
    while (scheduler.work_done() == before) std::this_thread::yield();
    EXPECT_EQ(scheduler.work_done() - before, items);
  }
}

TEST(Crew, OneThreadDividesNothing) {
  Scheduler scheduler(1);
  std::latch done(1);
  std::atomic<int> elsewhere = 0;
  Calling job([&] {
    EXPECT_EQ(CrewOfThisThread::find()->threads_at_hand(), 1u);
    const auto here = std::this_thread::get_id();
    for (int run = 0; run < 20; ++run)
      share_out(20, 1e8, [&](std::size_t) {
        std::this_thread::sleep_for(std::chrono::microseconds(20));
        elsewhere += std::this_thread::get_id() != here;
      });
    done.count_down();
    return false;
  });
  scheduler.submit(&job, JobKind::unsliced);
  done.wait();
  EXPECT_EQ(elsewhere, 0);
}

TEST(Crew, WhatAnItemThrowsIsThrown) {
  Scheduler scheduler(2);
  std::latch done(1);
  bool thrown = false;
  Calling job([&] {
    try {
      share_out(100, 1e9, [](std::size_t i) {
        if (i % 2) throw std::runtime_error("an item");
      });
    } catch (const std::runtime_error&) {
      thrown = true;
    }
    done.count_down();
    return false;
  });
  scheduler.submit(&job, JobKind::sliced);
  done.wait();
  EXPECT_TRUE(thrown);
}

}  // namespace
}  // namespace stiefel::server
