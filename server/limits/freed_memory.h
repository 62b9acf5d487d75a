#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "server/limits/memory_budget.h"

namespace stiefel::server {

/// Settings of malloc for this process: what is at least 512 KiB large goes back to the system when
/// it is freed, and there are two arenas a core. For programs, at their start; a library leaves its
/// host's settings alone.
void keep_little_freed_memory();

/// The thread that gives freed memory back to the system, if the process has 64 MiB or an eighth of
/// what is taken beyond that: when 64 MiB, or a sixty-fourth of a smaller budget, were given back
/// since it last did, and five seconds after it last did.
class FreedMemory {
 public:
  explicit FreedMemory(const MemoryBudget& budget);

 private:
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

}  // namespace stiefel::server
