#pragma once

#include <functional>
#include <latch>
#include <string>
#include <utility>

#include "server/scheduling/scheduler.h"

namespace stiefel::server {

/// Work in instructions that this thread's jobs have done: what a scheduler of a test counts in
/// place of processor time.
inline thread_local double work_done = 0;
inline double counted_work() { return work_done; }

/// A job of `slices` slices of `work` instructions each, which notes each in `order` by its name.
class CountedJob final : public Job {
 public:
  CountedJob(char name, int slices, double work, std::string* order = nullptr)
      : name_(name), left_(slices), work_(work), order_(order) {}
  CountedJob& of(Share& share, double price) {
    bill(share, price);
    return *this;
  }

  bool run_slice() noexcept override {
    if (order_) *order_ += name_;
    work_done += work_;
    if (--left_ > 0) return true;
    return false;
  }

 private:
  const char name_;
  int left_;
  const double work_;
  std::string* const order_;
};

/// The price of a job that has no end.
inline constexpr double endless = 1e30;

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

}  // namespace stiefel::server
