#pragma once

#include <cstddef>

namespace stiefel {

/// Threads that share work which a simulation divides. A program with threads of its own, like the
/// server, names its crew; without one all cores work (limit_ensemble_threads).
class Crew {
 public:
  using Item = void (*)(void* context, std::size_t index);

  virtual ~Crew() = default;
  /// Calls item(context, 0) ... item(context, count - 1), count ≥ 1, once each in any order on any
  /// thread, and returns when all are done; it rethrows what one throws. `nanoseconds`: roughly,
  /// for all of them together.
  virtual void run(std::size_t count, double nanoseconds, Item item, void* context) = 0;
};

/// While it lives, `for_each_in_parallel` on this thread goes to the crew.
class CrewOfThisThread {
 public:
  explicit CrewOfThisThread(Crew& crew);
  ~CrewOfThisThread();
  CrewOfThisThread(const CrewOfThisThread&) = delete;
  CrewOfThisThread& operator=(const CrewOfThisThread&) = delete;

  static Crew* find();
};

}  // namespace stiefel
