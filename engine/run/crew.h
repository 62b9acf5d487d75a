#pragma once

#include <cstddef>

namespace stiefel {

/// Threads that share the work into which a simulation divides a call. A program with threads of
/// its own, like the server, sets its crew (CrewOfThisThread); without one, all cores work
/// (limit_ensemble_threads).
class Crew {
 public:
  using Item = void (*)(void* context, std::size_t index);

  virtual ~Crew() = default;
  /// Calls item(context, 0) ... item(context, count - 1), count ≥ 1, once each, in any order on any
  /// thread, and returns when all are done. Rethrows what an item throws. `nanoseconds` is a rough
  /// estimate for all items together.
  virtual void run(std::size_t count, double nanoseconds, Item item, void* context) = 0;
};

/// Makes `for_each_in_parallel` on this thread use `crew` while the object lives.
class CrewOfThisThread {
 public:
  explicit CrewOfThisThread(Crew& crew);
  ~CrewOfThisThread();
  CrewOfThisThread(const CrewOfThisThread&) = delete;
  CrewOfThisThread& operator=(const CrewOfThisThread&) = delete;

  static Crew* find();
};

}  // namespace stiefel
