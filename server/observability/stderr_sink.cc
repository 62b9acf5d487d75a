#include "server/observability/stderr_sink.h"

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

bool write_stderr(std::string_view text, int wait) {
  while (!text.empty()) {
    if (!is_writable(wait)) return false;
    const auto written =
        ::write(STDERR_FILENO, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (written < 0 && errno != EINTR) return false;
    text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
  }
  return true;
}

bool StderrSink::write_line(const spdlog::details::log_msg& message, int wait) {
  spdlog::memory_buf_t formatted;
  formatter_->format(message, formatted);
  return write_stderr({formatted.data(), formatted.size()}, wait);
}

void StderrSink::sink_it_(const spdlog::details::log_msg& message) {
  const auto now = std::chrono::steady_clock::now();
  const bool blocked = last_drop_ && now - *last_drop_ < trust;
  if (dropped_ > 0) {
    auto lost = message;
    const std::string said = told_(dropped_);
    lost.level = spdlog::level::warn;
    lost.payload = said;
    if (write_line(lost, 0)) dropped_ = 0;
  }
  if (dropped_ == 0 && write_line(message, blocked ? 0 : patience)) return;
  ++dropped_;
  last_drop_ = now;
}

}  // namespace stiefel::server
