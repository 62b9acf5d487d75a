#include "server/scheduling/memory_limit.h"

#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <thread>

namespace stiefel::server {
namespace {

namespace fs = std::filesystem;

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
  constexpr const char* file = "memory.max";
  // Inside a container the group's path may be that on the host, while sys/fs/cgroup is the group.
  fs::path at = root / "sys/fs/cgroup";
  std::uint64_t least = std::min(machine_memory(root), number_in(at / file));
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::/")) continue;
    for (const fs::path& part : fs::path(line.substr(4)))
      least = std::min(least, number_in((at /= part) / file));
  }
  return least;
}

std::uint64_t default_memory() { return std::max(least_memory, available_memory() / 4 * 3); }

void keep_little_freed_memory() {
  constexpr int largest_kept = 512 << 10;
  mallopt(M_MMAP_THRESHOLD, largest_kept);
  mallopt(M_TRIM_THRESHOLD, 2 * largest_kept);
  mallopt(M_ARENA_MAX, 2 * std::max(static_cast<int>(std::thread::hardware_concurrency()), 2));
}

void give_back_freed_memory(std::uint64_t taken, std::uint64_t limit) {
  const std::uint64_t surplus = std::max(std::min(limit / 8, std::uint64_t{64} << 20), taken / 8);
  if (resident_bytes() > taken + surplus) malloc_trim(0);
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

}  // namespace stiefel::server
