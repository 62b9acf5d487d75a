#include "server/scheduling/priority.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

namespace stiefel::server {

void lower_priority(bool kept) noexcept {
  constexpr int nice_of_kept = 1, nice_of_others = 5;
  if (!kept) {
    const sched_param none{};
    sched_setscheduler(0, SCHED_BATCH, &none);
  }
  // On Linux the nice value is that of the thread.
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kept ? nice_of_kept : nice_of_others);
}

}  // namespace stiefel::server
