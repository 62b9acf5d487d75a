#include "server/store/reserve.h"

#include <fcntl.h>
#include <unistd.h>

namespace stiefel::server {

void Reserve::hold() noexcept {
  const int descriptor = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) return;
  const bool held = posix_fallocate(descriptor, 0, bytes) == 0;
  close(descriptor);
  if (!held) release();
}

void Reserve::release() noexcept { unlink(file_.c_str()); }

}  // namespace stiefel::server
