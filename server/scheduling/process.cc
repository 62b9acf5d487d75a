#include "server/scheduling/process.h"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <latch>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace stiefel::server {
namespace {

constexpr std::size_t stack_bytes = std::size_t{8} << 20;

std::string limit_of(decltype(RLIMIT_AS) resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "unlimited";
  return std::to_string(limit.rlim_cur);
}

}  // namespace

Periodic::Periodic(const char* name, std::chrono::milliseconds pause, Work work)
    : thread_([this, name, pause, work = std::move(work)](const std::stop_token& stop) {
        pthread_setname_np(pthread_self(), name);
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, stop, pause, [&] { return stop.stop_requested(); })) {
          try {
            work(stop);
          } catch (const std::exception&) {
          }
        }
      }) {}

void enlarge_thread_stacks() {
  pthread_attr_t attributes;
  std::size_t now = 0;
  if (pthread_getattr_default_np(&attributes) != 0) return;
  if (pthread_attr_getstacksize(&attributes, &now) == 0 && now < stack_bytes &&
      pthread_attr_setstacksize(&attributes, stack_bytes) == 0)
    pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

std::optional<std::string> thread_fault(int count) {
  std::latch end(1);
  std::vector<std::jthread> threads;
  std::string reason;
  try {
    while (static_cast<int>(threads.size()) < count)
      threads.emplace_back([&end] {
        // The first allocation of a thread takes address space for more.
        const std::unique_ptr<volatile char> allocation(new volatile char);
        end.wait();
      });
  } catch (const std::exception& error) {
    reason = "the system gives " + std::to_string(threads.size()) + " of " + std::to_string(count) +
             " threads: " + error.what() + " (processes, ulimit -u: " + limit_of(RLIMIT_NPROC) +
             "; bytes of address space, ulimit -v: " + limit_of(RLIMIT_AS) +
             "; or the control group's limits)";
  }
  end.count_down();
  threads.clear();
  return reason.empty() ? std::nullopt : std::optional(reason);
}

std::size_t descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
    return std::numeric_limits<int>::max();
  return static_cast<std::size_t>(limit.rlim_cur);
}

void raise_descriptor_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace stiefel::server
