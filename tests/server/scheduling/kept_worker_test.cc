// The worker that is kept for short calls while the others search.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <latch>
#include <list>
#include <semaphore>
#include <string>

#include "server/scheduling/slice.h"
#include "tests/server/scheduling/scheduling.h"

namespace stiefel::server {
namespace {

/// The kinds of job that run while every worker but the kept one is inside a search.
TEST(KeptWorker, RunsNoSearches) {
  for (const int threads : {2, 3}) {
    const int others = threads - 1;
    std::latch searching(others), release(1), ran(3), rest(others);
    std::atomic<int> searches = 0, at_most = 0;
    Share share;
    std::list<Calling> jobs;
    Scheduler scheduler(threads);
    for (int i = 0; i < 2 * others; ++i) {
      jobs.emplace_back([&, i] {
        at_most = std::max<int>(at_most, ++searches);
        if (i < others) searching.count_down();
        release.wait();
        --searches;
        if (i >= others) rest.count_down();
        return false;
      });
      scheduler.submit(&jobs.back().of(share, 0), JobKind::unsliced);
    }
    searching.wait();
    // A short one, and longer ones that have slices: all done by the worker that is kept.
    for (const JobKind kind : {JobKind::sliced, JobKind::brief, JobKind::sliced}) {
      jobs.emplace_back([&, left = 5]() mutable {
        if (--left > 0) return true;
        ran.count_down();
        return false;
      });
      scheduler.submit(&jobs.back().of(share, jobs.size() % 2 ? endless : 1), kind);
    }
    ran.wait();
    EXPECT_EQ(searches, others) << "the searches still run";
    release.count_down();
    rest.wait();
    EXPECT_LE(at_most, others) << threads;
  }
}

/// A call just longer than a short one does not wait for the slices of another principal's long
/// calls, although its own steps are too long for the slices of long calls on the kept worker.
TEST(KeptWorker, RunsMediumJobsWhileTheOthersComputeLongOnes) {
  std::latch busy(1), release(1), medium(1), idle(1);
  Share heavy, other;
  double longest_slice = 0;
  Calling slice([&] {
    busy.count_down();
    release.wait();
    idle.count_down();
    return false;
  });
  Calling job([&, left = 3]() mutable {
    longest_slice = static_cast<double>(slice_steps(1.0));
    if (--left > 0) return true;
    medium.count_down();
    return false;
  });
  {
    Scheduler scheduler(2);
    scheduler.submit(&slice.of(heavy, endless), JobKind::sliced);
    busy.wait();
    scheduler.submit(&job.of(other, 1.2 * short_work + 1e6), JobKind::sliced);
    medium.wait();  // while the slice of the long call goes on
    release.count_down();
    idle.wait();
  }
  EXPECT_LE(longest_slice, brief_slice_nanoseconds) << "a short call waits no longer for it";
}

/// A principal whose searches do not end holds up its own further searches, and no other principal:
/// not a second one, and not a third one while the second one searches too.
TEST(KeptWorker, ASearchOfOnePrincipalHoldsUpNoOther) {
  for (const int threads : {1, 2, 3}) {
    const int others = std::max(1, threads - 1);
    std::latch searching(others), release(1), rest(2 * others + 1);
    std::counting_semaphore<8> second_began(0), third_done(0);
    std::atomic<int> searches = 0;
    Share greedy, second, third;
    std::list<Calling> jobs;
    Scheduler scheduler(threads);
    const auto submit = [&](Share& share, JobKind kind, std::function<bool()> work) {
      jobs.emplace_back(std::move(work));
      scheduler.submit(&jobs.back().of(share, endless), kind);
    };
    for (int i = 0; i < 2 * others; ++i) {
      submit(greedy, JobKind::unsliced, [&, i] {
        ++searches;
        if (i < others) searching.count_down();
        release.wait();
        rest.count_down();
        return false;
      });
    }
    searching.wait();
    submit(second, JobKind::unsliced, [&] {
      second_began.release();
      release.wait();
      rest.count_down();
      return false;
    });
    EXPECT_TRUE(second_began.try_acquire_for(std::chrono::seconds(10))) << threads;
    for (const JobKind kind : {JobKind::unsliced, JobKind::sliced, JobKind::unsliced}) {
      submit(third, kind, [&, left = 5]() mutable {
        if (--left > 0) return true;
        third_done.release();
        return false;
      });
    }
    for (int i = 0; i < 3; ++i)
      EXPECT_TRUE(third_done.try_acquire_for(std::chrono::seconds(10))) << threads;
    EXPECT_EQ(searches, others) << "the further searches of the first principal wait";
    release.count_down();
    rest.wait();
  }
}

/// Two workers: the kept one leaves a sliced job to the other.
TEST(KeptWorker, RunsLongJobsInBriefSlicesOnly) {
  std::latch begun(2), release(1);
  std::atomic<std::int64_t> first = 0, second = 0;
  Share share;
  Calling on_other([&] {
    first = slice_steps(200);
    begun.count_down();
    release.wait();
    return false;
  });
  Calling on_kept([&] {
    second = slice_steps(200);
    begun.count_down();
    release.wait();
    return false;
  });
  Scheduler scheduler(2);
  scheduler.submit(&on_other.of(share, endless), JobKind::sliced);
  scheduler.submit(&on_kept.of(share, endless), JobKind::brief);
  begun.wait();
  release.count_down();
  EXPECT_EQ(first, 10'000);
  EXPECT_EQ(second, 1000);
}

TEST(KeptWorker, GivesWayToConnectionsAndOthersToIt) {
  std::latch done(2), both(2), begun(1);
  std::array<std::atomic<int>, 2> nice{};
  std::array<std::string, 2> names;
  std::list<Calling> jobs;
  Share share;
  Scheduler scheduler(2);
  for (std::size_t i = 0; i < 2; ++i) {
    jobs.emplace_back([&, i] {
      if (i == 0) begun.count_down();
      both.arrive_and_wait();
      nice[i] = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
      char name[16] = {};
      pthread_getname_np(pthread_self(), name, sizeof name);
      names[i] = name;
      done.count_down();
      return false;
    });
    scheduler.submit(&jobs.back().of(share, i == 0 ? endless : 1), JobKind::sliced);
    begun.wait();  // the endless one is on the other worker, and the short one has the kept
  }
  done.wait();
  const int own = getpriority(PRIO_PROCESS, 0);
  EXPECT_GT(nice[0], std::min(nice[1].load(), 18)) << "the kept worker is before the others";
  EXPECT_GT(nice[1], std::min(own, 18));
  EXPECT_EQ(names[0], Scheduler::thread_name);
  EXPECT_EQ(names[1], Scheduler::thread_name);
}

}  // namespace
}  // namespace stiefel::server
