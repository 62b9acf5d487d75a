#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace stiefel::server {

/// The length of a slice of work, and the longest work that runs on the thread that received the
/// request, in nanoseconds.
inline constexpr double slice_nanoseconds = 2e6;
inline constexpr double inline_nanoseconds = 5e4;

/// The steps of a slice: a number of the scene, not of the clock, so that it can be tested.
std::int64_t slice_steps(double step_cost);

/// Long work in short slices.
class Job {
 public:
  virtual ~Job() = default;
  /// Does one slice. True: queue it again. False: the pool forgets the job, which may be gone by
  /// then.
  virtual bool run_slice() noexcept = 0;

 private:
  friend class Pool;
  Job* next_ = nullptr;  // in the pool's queue
};

/// Threads that run jobs one slice at a time, in the order of arrival. After a slice a job goes to
/// the end of the queue, so a long job delays a short one by one slice.
class Pool {
 public:
  /// What ps and top call its threads.
  static constexpr const char* thread_name = "compute";

  /// 0 threads means one a core.
  explicit Pool(int threads);
  /// Runs what is queued to its end.
  ~Pool();
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  /// The job must live until its `run_slice` returns false. Allocates nothing: a job that is
  /// submitted runs, whatever memory is left.
  void submit(Job* job) noexcept;
  int threads() const { return static_cast<int>(workers_.size()); }

 private:
  void work();
  void push(Job* job);
  Job* pop();

  std::mutex mutex_;
  std::condition_variable wake_;
  Job* first_ = nullptr;  // the queue, linked by `next_`; guarded by mutex_
  Job* last_ = nullptr;   // guarded by mutex_, as the rest is
  int idle_ = 0;
  bool stopping_ = false;
  std::vector<std::jthread> workers_;
};

}  // namespace stiefel::server
