#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>

namespace stiefel {

/// Threads that share the work into which a call is divided: the members of an ensemble, blocks of
/// the products of large matrices, blocks of the columns of long frames. The bits of a result
/// depend neither on the number of threads nor on which of them did what. A program with threads of
/// its own, like the server, sets its crew (CrewOfThisThread); without one, threads of the library
/// work, one for each core (limit_threads).
class Crew {
 public:
  using Item = void (*)(void* context, std::size_t index);

  virtual ~Crew() = default;
  /// Returns about how many threads would share a `run` on this thread now, with the calling one.
  virtual std::size_t threads_at_hand() = 0;
  /// Calls item(context, 0) ... item(context, count - 1), count ≥ 1, once each, in any order on any
  /// thread, and returns when all are done. Rethrows what an item throws; some of the other items
  /// are then not called. `nanoseconds` is a rough estimate for all items together.
  virtual void run(std::size_t count, double nanoseconds, Item item, void* context) = 0;
};

/// Makes the work that this thread divides go to `crew` while the object lives.
class CrewOfThisThread {
 public:
  explicit CrewOfThisThread(Crew& crew);
  ~CrewOfThisThread();
  CrewOfThisThread(const CrewOfThisThread&) = delete;
  CrewOfThisThread& operator=(const CrewOfThisThread&) = delete;

  /// Returns the crew that this thread may use now: null within an item, whose own work is not
  /// divided again, and where none is set.
  static Crew* find();
};

/// Limits the threads of the library that work at once to `threads` - 1 ≥ 0 beside the threads that
/// call it. The default is one thread for each core, with the calling one.
void limit_threads(int threads);

/// What a thread, the leader, shares out, and the threads that help it; for those who write a crew.
/// Helpers stay for a while after a run and wait for the next one without sleep, because to wake a
/// thread takes as long as many runs. Thread-safe.
class Team {
 public:
  /// How long a helper waits for the leader's next run.
  static constexpr std::chrono::microseconds patience{100};

  /// Runs the items as Crew::run does, on this thread and those inside `help`; a thread takes
  /// `portion` of them at a time. Only the leader calls it, and not within an item.
  void run(std::size_t count, std::size_t portion, Crew::Item item, void* context);

  /// Takes part in the leader's runs, until `leave` returns true or for `patience` without one.
  /// `meter` returns the work that the calling thread has done so far. Returns whether it left for
  /// want of work.
  bool help(const std::function<bool()>& leave, const std::function<double()>& meter);

  /// Returns the work that helpers have done in the runs since the last call. Only the leader calls
  /// it.
  double take_helpers_work() { return helpers_work_.exchange(0, std::memory_order_relaxed); }

 private:
  struct Run;

  std::atomic<Run*> run_ = nullptr;
  std::atomic<std::uint64_t> runs_ = 0;    // so far
  std::atomic<std::uint32_t> inside_ = 0;  // helpers that may hold run_
  std::atomic<double> helpers_work_ = 0;
};

}  // namespace stiefel
