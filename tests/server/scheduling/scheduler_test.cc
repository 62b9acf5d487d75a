#include "server/scheduling/scheduler.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <barrier>
#include <latch>
#include <list>
#include <semaphore>
#include <stdexcept>
#include <thread>

#include "server/scheduling/slice.h"
#include "tests/server/scenes.h"
#include "tests/server/scheduling/scheduling.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::server {
namespace {

constexpr double endless = 1e30;

/// A job of a function, one slice for each call of it that returns true.
class Calling final : public Job {
 public:
  explicit Calling(std::function<bool()> slice) : slice_(std::move(slice)) {}
  Calling& of(Share& share, double price) {
    bill(share, price);
    return *this;
  }
  bool run_slice() noexcept override { return slice_(); }

 private:
  std::function<bool()> slice_;
};

TEST(Scheduler, JobsTakeTurns) {
  std::string order;
  std::latch begun(1), queued(1), done(3);
  Calling gate([&] {
    begun.count_down();
    queued.wait();
    return false;
  });
  CountedJob long_job('l', 5, short_work, &order), short_job('s', 1, 1, &order),
      other('o', 2, short_work, &order);
  Share share;
  {
    Scheduler scheduler(1, counted_work);
    scheduler.submit(&gate, JobKind::brief);
    begun.wait();
    scheduler.submit(&long_job.of(share, endless).until(&done), JobKind::brief);
    scheduler.submit(&other.of(share, endless).until(&done), JobKind::brief);
    scheduler.submit(&short_job.of(share, 1).until(&done), JobKind::brief);
    queued.count_down();
    done.wait();
  }
  EXPECT_EQ(order, "slololll");
}

TEST(Scheduler, TellsTheWorkOfASliceAndOfAll) {
  std::vector<double> taken;
  {
    std::latch done(1);
    Scheduler scheduler(1, &counted_work);
    Calling job([&] {
      work_done += 5;
      taken.push_back(take_slice_work());
      work_done += 3;
      taken.push_back(take_slice_work());
      taken.push_back(take_slice_work());
      if (taken.size() < 6) return true;
      done.count_down();
      return false;
    });
    scheduler.submit(&job, JobKind::brief);
    done.wait();
    while (scheduler.work_done() < 16) std::this_thread::yield();
    EXPECT_EQ(scheduler.work_done(), 16);
    EXPECT_EQ(scheduler.waiting_work(), 0U);
  }
  EXPECT_EQ(taken, (std::vector<double>{5, 3, 0, 5, 3, 0}));
  EXPECT_EQ(take_slice_work(), 0) << "outside a slice";
}

TEST(Scheduler, FinishesWhatIsQueued) {
  std::atomic<int> slices = 0;
  std::list<Calling> jobs;
  {
    Scheduler scheduler(2);
    for (const JobKind kind : {JobKind::brief, JobKind::sliced, JobKind::unsliced})
      scheduler.submit(
          &jobs.emplace_back([&, left = 100]() mutable { return ++slices, --left > 0; }), kind);
  }
  EXPECT_EQ(slices, 300);
}

/// A job that keeps the only worker for longer jobs inside a slice until `open`. It must outlive
/// the scheduler.
class Gate {
 public:
  void close(Scheduler& scheduler) {
    scheduler.submit(&job_, JobKind::unsliced);
    begun_.wait();
  }
  void open() { end_.count_down(); }

 private:
  std::latch begun_{1}, end_{1};
  Calling job_{[this] {
    begun_.count_down();
    end_.wait();
    return false;
  }};
};

TEST(Scheduler, AHastenedJobRunsOutOfItsTurn) {
  Share share;
  int slices = 0;
  std::thread::id ran_on;
  Calling waiting([&] {
    ran_on = std::this_thread::get_id();
    return ++slices < 2;
  });
  Calling other([] { return false; });
  Gate gate;
  Scheduler scheduler(2);
  gate.close(scheduler);
  scheduler.submit(&other.of(share, endless), JobKind::unsliced);
  scheduler.submit(&waiting.of(share, endless), JobKind::unsliced);
  scheduler.hasten(&waiting);
  EXPECT_EQ(slices, 2);
  EXPECT_EQ(ran_on, std::this_thread::get_id());
  gate.open();
}

TEST(Scheduler, AJobHastenedInItsSliceDoesNotWaitForTheNextOne) {
  Share share;
  std::latch begun(1), hastened(1), done(1);
  std::atomic<int> slices = 0;
  std::atomic<bool> others_done = false;
  bool before_others = false;
  Calling job([&] {
    if (++slices == 1) {
      begun.count_down();
      hastened.wait();
      return true;
    }
    before_others = !others_done;
    done.count_down();
    return false;
  });
  Calling other([&] {
    others_done = true;
    return false;
  });
  Scheduler scheduler(1);
  scheduler.submit(&job.of(share, endless), JobKind::sliced);
  begun.wait();
  scheduler.submit(&other.of(share, endless), JobKind::sliced);
  scheduler.hasten(&job);
  hastened.count_down();
  done.wait();
  EXPECT_TRUE(before_others);
}

TEST(Scheduler, AJobHastenedAtRestRunsWhenItIsSubmitted) {
  Share share;
  int slices = 0;
  Calling resting([&] { return ++slices < 3; });
  Gate gate;
  Scheduler scheduler(2);
  gate.close(scheduler);
  resting.of(share, endless);
  scheduler.hasten(&resting);
  EXPECT_EQ(slices, 0);
  scheduler.submit(&resting, JobKind::unsliced);
  EXPECT_EQ(slices, 3);
  gate.open();
}

TEST(Scheduler, OneThreadRunsShortJobsBesideAWholeSlice) {
  using std::chrono::seconds;
  std::binary_semaphore begun(0), short_done(0);
  std::atomic<int> long_slices = 0;
  bool in_time = false;
  Calling unsliced([&] {
    begun.release();
    in_time = short_done.try_acquire_for(seconds(30));
    EXPECT_EQ(long_slices, 0) << "one thread computes";
    return false;
  });
  Calling long_job([&] { return ++long_slices < 3; });
  Calling short_job([&] {
    short_done.release();
    return false;
  });
  Share share, other;
  {
    Scheduler scheduler(1);
    EXPECT_EQ(scheduler.threads(), 1);
    scheduler.submit(&unsliced, JobKind::unsliced);
    begun.acquire();
    scheduler.submit(&long_job.of(share, endless), JobKind::brief);
    scheduler.submit(&short_job.of(other, 1), JobKind::brief);
  }
  EXPECT_TRUE(in_time);
  EXPECT_EQ(long_slices, 3);
}

TEST(Scheduler, AJobMaySubmitItselfAsAnotherKind) {
  std::latch done(1);
  Scheduler scheduler(2);
  int phase = 0;
  Calling job([&] {
    if (++phase == 1) {
      scheduler.submit(&job, JobKind::unsliced);
      return false;
    }
    done.count_down();
    return false;
  });
  scheduler.submit(&job, JobKind::brief);
  done.wait();
  EXPECT_EQ(phase, 2);
}

TEST(Scheduler, ManyThreadsSubmit) {
  constexpr int count = 400;
  std::atomic<int> slices = 0;
  std::list<Calling> jobs;
  std::vector<Calling*> all;
  for (int i = 0; i < count; ++i)
    all.push_back(
        &jobs.emplace_back([&slices, left = 3]() mutable { return ++slices, --left > 0; }));
  std::array<Share, 3> shares;
  for (std::size_t i = 0; i < count; ++i) all[i]->of(shares[i % 3], i % 2 ? endless : 1);
  {
    Scheduler scheduler(4);
    std::vector<std::jthread> submitters;
    for (std::size_t t = 0; t < 4; ++t) {
      submitters.emplace_back([&, t] {
        for (std::size_t i = t; i < count; i += 4)
          scheduler.submit(all[i], static_cast<JobKind>(i % 3));
      });
    }
  }
  EXPECT_EQ(slices, 3 * count);
}

/// The kinds of job that run while every worker but the kept one is inside a search.
TEST(Scheduler, OneWorkerIsKeptFromSearches) {
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

/// A principal whose searches do not end holds up its own further searches, and no other principal:
/// not a second one, and not a third one while the second one searches too.
TEST(Scheduler, ASearchOfOnePrincipalHoldsUpNoOther) {
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
TEST(Scheduler, TheKeptWorkerRunsLongJobsInBriefSlicesOnly) {
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

TEST(Scheduler, ItsThreadsGiveWayToOthers) {
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
