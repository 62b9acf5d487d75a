#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/limits/memory_budget.h"

namespace stiefel::server {

/// Sets malloc up for this process: blocks of at least 512 KiB go back to the system when they are
/// freed, and there are two arenas a core. For programs, at their start; a library leaves the
/// settings of its host alone.
void keep_little_freed_memory();

/// A thread that gives freed memory back to the system when the process holds more than the budget
/// says is taken, by 64 MiB (an eighth of a budget below 512 MiB) and by an eighth of what is
/// taken. Does so only once 64 MiB (a sixty-fourth of a budget below 4 GiB) were given back to the
/// budget, or five seconds have passed, since the last time.
class FreedMemory {
 public:
  explicit FreedMemory(const MemoryBudget& budget);

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace stiefel::server
