// The parts of an ensemble that idle workers compute.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <latch>
#include <list>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/server/scenes.h"
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
