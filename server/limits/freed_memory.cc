#include "server/limits/freed_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>

namespace stiefel::server {
namespace {

constexpr auto pause = std::chrono::milliseconds(500);
constexpr auto longest_wait = std::chrono::seconds(5);
/// The least bytes given back since the last trim, and the least resident bytes beyond those taken.
constexpr std::uint64_t least_given_back = std::uint64_t{64} << 20;
constexpr std::uint64_t least_surplus = std::uint64_t{64} << 20;
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
        using Clock = std::chrono::steady_clock;
        std::uint64_t trimmed_at = 0;
        Clock::time_point last = Clock::now();
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); })) {
          const std::uint64_t now = budget.given_back();
          // The budget does not count what gRPC frees, hence the limit on the time.
          if (now - trimmed_at < std::min(budget.limit() / 64, least_given_back) &&
              Clock::now() - last < longest_wait)
            continue;
          const std::uint64_t used = budget.used();
          const std::uint64_t surplus = std::min(budget.limit() / 8, least_surplus);
          if (resident_bytes() < used + std::max(surplus, used / 8)) continue;
          trimmed_at = now;
          last = Clock::now();
          malloc_trim(0);
        }
      }) {}

}  // namespace stiefel::server
