#include "server/admission/stderr_sink.h"

#include <limits.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

namespace stiefel::server {
namespace {

/// Whether stderr accepts PIPE_BUF bytes without blocking, within `wait` milliseconds.
bool is_writable(int wait) {
  pollfd descriptor{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&descriptor, 1, wait) > 0;
}

}  // namespace

bool StderrSink::write_line(const spdlog::details::log_msg& message, int wait) {
  spdlog::memory_buf_t formatted;
  formatter_->format(message, formatted);
  std::string_view line(formatted.data(), formatted.size());
  while (!line.empty()) {
    if (!is_writable(wait)) return false;
    const auto written =
        write(STDERR_FILENO, line.data(), std::min<std::size_t>(line.size(), PIPE_BUF));
    if (written < 0 && errno != EINTR) return false;
    line.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return true;
}

void StderrSink::sink_it_(const spdlog::details::log_msg& message) {
  const bool blocked = dropped_ > 0;
  if (blocked) {
    auto lost = message;
    const std::string said = told_(dropped_);
    lost.level = spdlog::level::warn;
    lost.payload = said;
    if (write_line(lost, 0)) dropped_ = 0;
  }
  if (dropped_ > 0 || !write_line(message, blocked ? 0 : patience)) ++dropped_;
}

}  // namespace stiefel::server
