#include "server/scheduling/process.h"

#include <pthread.h>
#include <sys/resource.h>

#include <exception>
#include <limits>

namespace stiefel::server {
namespace {

constexpr std::size_t stack_bytes = std::size_t{8} << 20;

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
