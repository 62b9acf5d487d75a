#include "server/limits/freed_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>

namespace stiefel::server {
namespace {

constexpr auto pause = std::chrono::milliseconds(500);
constexpr int largest_kept = 512 * 1024, arenas_a_core = 2;

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace

void keep_little_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, largest_kept);
  mallopt(M_TRIM_THRESHOLD, 2 * largest_kept);
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  mallopt(M_ARENA_MAX, arenas_a_core * std::max(cores, 2));
}

FreedMemory::FreedMemory(const MemoryBudget& budget)
    : thread_([this, &budget](const std::stop_token& stop) {
        std::uint64_t trimmed_at = 0;
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); })) {
          const std::uint64_t now = budget.given_back();
          if (now - trimmed_at < budget.limit() / 64) continue;
          if (resident_bytes() < budget.used() + budget.limit() / 8) continue;
          trimmed_at = now;
          malloc_trim(0);
        }
      }) {}

}  // namespace stiefel::server
