#include "server/scheduling/scheduler.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <latch>
#include <list>
#include <semaphore>
#include <thread>
#include <vector>

#include "server/scheduling/slice.h"
#include "tests/server/scheduling/scheduling.h"

namespace stiefel::server {
namespace {

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

TEST(Scheduler, ACancelledJobRunsOutOfItsTurn) {
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
  scheduler.cancel(&waiting);
  EXPECT_EQ(slices, 2);
  EXPECT_EQ(ran_on, std::this_thread::get_id());
  gate.open();
}

TEST(Scheduler, AJobCancelledInItsSliceDoesNotWaitForTheNextOne) {
  Share share;
  std::latch begun(1), cancelled(1), done(1);
  std::atomic<int> slices = 0;
  std::atomic<bool> others_done = false;
  bool before_others = false;
  Calling job([&] {
    if (++slices == 1) {
      begun.count_down();
      cancelled.wait();
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
  scheduler.cancel(&job);
  cancelled.count_down();
  done.wait();
  EXPECT_TRUE(before_others);
}

TEST(Scheduler, AJobCancelledAtRestRunsWhenItIsSubmitted) {
  Share share;
  int slices = 0;
  Calling resting([&] { return ++slices < 3; });
  Gate gate;
  Scheduler scheduler(2);
  gate.close(scheduler);
  resting.of(share, endless);
  scheduler.cancel(&resting);
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

TEST(Slices, AreNumbersOfSteps) {
  EXPECT_EQ(slice_steps(200), 10'000);
  EXPECT_EQ(slice_steps(2e6), 1);
  EXPECT_EQ(slice_steps(1e12), 1) << "a slice is never empty";
  EXPECT_EQ(slice_steps(0), 2'000'000) << "a cost of nothing is not believed";
  {
    const SliceLength length(brief_slice_nanoseconds);
    EXPECT_EQ(slice_steps(200), 1000);
    {
      const SliceLength inner(slice_nanoseconds / 2);
      EXPECT_EQ(slice_steps(200), 5000);
    }
    EXPECT_EQ(slice_steps(200), 1000);
  }
  EXPECT_EQ(slice_steps(200), 10'000);
}

TEST(Slices, StepsSayTheirKind) {
  EXPECT_EQ(kind_of_steps(1), JobKind::brief);
  EXPECT_EQ(kind_of_steps(brief_slice_nanoseconds), JobKind::brief);
  EXPECT_EQ(kind_of_steps(slice_nanoseconds), JobKind::sliced);
  EXPECT_EQ(kind_of_steps(1.1 * slice_nanoseconds), JobKind::unsliced);
}

}  // namespace
}  // namespace stiefel::server
