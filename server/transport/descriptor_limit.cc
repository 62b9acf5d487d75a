#include "server/transport/descriptor_limit.h"

#include <sys/resource.h>

#include <algorithm>
#include <limits>

namespace stiefel::server {

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

std::size_t possible_connections(std::size_t asked) {
  const std::size_t limit = descriptor_limit();
  const std::size_t possible = limit > reserved_descriptors ? limit - reserved_descriptors : 1;
  return asked == 0 ? possible : std::min(asked, possible);
}

}  // namespace stiefel::server
