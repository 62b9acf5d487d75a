#include "server/sessions/pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <latch>
#include <mutex>
#include <string>

namespace stiefel::server {
namespace {

class Counting final : public Job {
 public:
  explicit Counting(std::function<bool()> slice) : slice_(std::move(slice)) {}
  bool run_slice() noexcept override { return slice_(); }

 private:
  std::function<bool()> slice_;
};

TEST(Pool, SlicesAreNumbersOfSteps) {
  EXPECT_EQ(slice_steps(200), 10'000);
  EXPECT_EQ(slice_steps(2e6), 1);
  EXPECT_EQ(slice_steps(1e12), 1) << "a slice is never empty";
  EXPECT_EQ(slice_steps(0), 2'000'000) << "a cost of nothing is not believed";
}

TEST(Pool, JobsTakeTurns) {
  std::string order;
  std::latch queued(1), done(3);
  const auto job = [&](char name, int slices) {
    return Counting([&order, &done, name, left = slices]() mutable {
      order += name;
      if (--left > 0) return true;
      done.count_down();
      return false;
    });
  };
  Counting gate([&] {
    queued.wait();
    return false;
  });
  Counting long_job = job('l', 5), short_job = job('s', 1), other = job('o', 2);
  Pool pool(1);
  pool.submit(&gate);
  pool.submit(&long_job);
  pool.submit(&short_job);
  pool.submit(&other);
  queued.count_down();
  done.wait();
  EXPECT_EQ(order, "lsololll");
}

TEST(Pool, FinishesWhatIsQueued) {
  std::atomic<int> slices = 0;
  Counting job([&] { return ++slices < 100; });
  {
    Pool pool(2);
    pool.submit(&job);
  }
  EXPECT_EQ(slices, 100);
}

TEST(Pool, ManyThreadsSubmit) {
  constexpr int jobs = 400;
  std::atomic<int> slices = 0;
  std::vector<Counting> all;
  for (int i = 0; i < jobs; ++i) {
    all.emplace_back([&slices, left = 3]() mutable { return ++slices, --left > 0; });
  }
  {
    Pool pool(4);
    std::vector<std::jthread> submitters;
    for (int t = 0; t < 4; ++t) {
      submitters.emplace_back([&, t] {
        for (int i = t; i < jobs; i += 4) pool.submit(&all[static_cast<std::size_t>(i)]);
      });
    }
  }
  EXPECT_EQ(slices, 3 * jobs);
}

}  // namespace
}  // namespace stiefel::server
