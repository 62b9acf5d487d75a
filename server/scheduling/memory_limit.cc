#include "server/scheduling/memory_limit.h"

#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <thread>

namespace stiefel::server {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t MiB = std::uint64_t{1} << 20;
constexpr std::uint64_t unknown = std::numeric_limits<std::uint64_t>::max();

/// Returns the number at the start of a file; `unknown` for "max" and for a missing file.
std::uint64_t number_in(const fs::path& file) {
  std::ifstream in(file);
  std::uint64_t number = 0;
  return in >> number ? number : unknown;
}

std::uint64_t machine_memory(const fs::path& root) {
  std::ifstream in(root / "proc/meminfo");
  std::string name;
  std::uint64_t kilobytes = 0;
  while (in >> name >> kilobytes) {
    if (name == "MemTotal:") return kilobytes * 1024;
    in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return unknown;
}

/// Returns the smallest limit of a control group and the groups that contain it, below `mount`.
std::uint64_t group_limit(const fs::path& mount, const fs::path& group, const char* file) {
  // Inside a container the group's path may be that on the host, while `mount` is the group itself.
  std::uint64_t least = number_in(mount / file);
  fs::path at = mount;
  for (const fs::path& part : group.relative_path()) {
    at /= part;
    least = std::min(least, number_in(at / file));
  }
  return least;
}

constexpr auto trim_pause = std::chrono::milliseconds(500);
constexpr auto longest_wait = std::chrono::seconds(5);
/// The least bytes given back since the last trim, and the least resident bytes beyond those taken.
constexpr std::uint64_t least_given_back = std::uint64_t{64} << 20;
constexpr std::uint64_t least_surplus = std::uint64_t{64} << 20;
constexpr int largest_kept = 512 * 1024, arenas_a_core = 2;
/// Pages of a stack that stay, for the functions that are called next.
constexpr std::uintptr_t pages_of_the_next_calls = 16;

}  // namespace

std::uint64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::optional<std::uint64_t> read_bytes(std::string_view text, std::uint64_t least) {
  constexpr std::string_view suffixes = "KMGT";
  double unit = 1;
  if (!text.empty()) {
    const auto power = suffixes.find(text.back());
    if (power != std::string_view::npos) {
      unit = std::ldexp(1.0, 10 * static_cast<int>(power + 1));
      text.remove_suffix(1);
    }
  }
  double number = 0;
  const auto read =
      std::from_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  const double bytes = number * unit;
  if (!(bytes >= static_cast<double>(least) && bytes <= 0x1p60)) return std::nullopt;
  return static_cast<std::uint64_t>(bytes);
}

std::uint64_t available_memory(const fs::path& root) {
  std::uint64_t least = machine_memory(root);
  const fs::path mount = root / "sys/fs/cgroup";
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // "0::/path" or "4:memory:/path"
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty())
      least = std::min(least, group_limit(mount, group, "memory.max"));
    else if ((',' + controllers + ',').find(",memory,") != std::string::npos)
      least = std::min(least, group_limit(mount / "memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

std::uint64_t default_memory() { return std::max(least_memory, available_memory() / 4 * 3); }

std::uint64_t largest_message(std::uint64_t memory) { return std::min(256 * MiB, memory / 16); }

std::uint64_t grpc_share(std::uint64_t memory) { return memory / 4; }

std::uint64_t program_share(std::uint64_t memory) { return std::min(32 * MiB, memory / 8); }

std::uint64_t session_share(std::uint64_t memory) {
  return memory - grpc_share(memory) - program_share(memory);
}

void keep_little_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, largest_kept);
  mallopt(M_TRIM_THRESHOLD, 2 * largest_kept);
  const auto cores = static_cast<int>(std::thread::hardware_concurrency());
  mallopt(M_ARENA_MAX, arenas_a_core * std::max(cores, 2));
}

void give_back_unused_stack() {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
  void* low = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &low, &size);
  pthread_attr_destroy(&attributes);
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(low);
  const auto here = reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0));
  const std::uintptr_t end = (here / page - pages_of_the_next_calls) * page;
  if (end > begin) madvise(low, end - begin, MADV_DONTNEED);
}

FreedMemory::FreedMemory(const MemoryBudget& budget)
    : budget_(budget), thread_("freed-memory", trim_pause, [this](const auto&) { trim(); }) {}

void FreedMemory::trim() {
  const std::uint64_t given_back = budget_.given_back(), used = budget_.used();
  const auto now = std::chrono::steady_clock::now();
  // The budget does not count what gRPC frees, hence the limit on the time.
  if (given_back - trimmed_at_ < std::min(budget_.limit() / 64, least_given_back) &&
      now - last_ < longest_wait)
    return;
  const std::uint64_t surplus = std::min(budget_.limit() / 8, least_surplus);
  if (resident_bytes() < used + std::max(surplus, used / 8)) return;
  trimmed_at_ = given_back;
  last_ = now;
  malloc_trim(0);
}

}  // namespace stiefel::server
