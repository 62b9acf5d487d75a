#include "server/scheduling/priority.h"

#include <sched.h>
#include <sys/resource.h>

namespace stiefel::server {

void lower_priority(bool kept) noexcept {
  constexpr int kept_below = 1, others_below = 5;
  if (!kept) {
    const sched_param none{};
    sched_setscheduler(0, SCHED_BATCH, &none);
  }
  // On Linux, 0 means the calling thread, and each thread has its own nice value.
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + (kept ? kept_below : others_below));
}

}  // namespace stiefel::server
