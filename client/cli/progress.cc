#include "client/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <iostream>
#include <mutex>

namespace stiefel::cli {

std::string progress_line(std::int64_t step, std::int64_t to, double steps_per_second, int width) {
  const double fraction = to > 0 ? static_cast<double>(step) / static_cast<double>(to) : 1;
  const int filled = static_cast<int>(fraction * width);
  const std::string bar = std::string(filled, '=') + std::string(width - filled, ' ');
  char line[256];
  std::snprintf(line, sizeof line, "[%s] %3d %%  step %lld of %lld  %.3g steps/s", bar.c_str(),
                static_cast<int>(fraction * 100), static_cast<long long>(step),
                static_cast<long long>(to), steps_per_second);
  return line;
}

Progress::Progress(const client::Session& session, std::int64_t to) : session_(session), to_(to) {
  if (isatty(STDERR_FILENO)) watcher_ = std::jthread([this](std::stop_token stop) { watch(stop); });
}

Progress::~Progress() = default;

void Progress::watch(const std::stop_token& stop) {
  using namespace std::chrono_literals;
  std::mutex mutex;
  std::condition_variable_any wake;
  std::unique_lock lock(mutex);
  const auto start = std::chrono::steady_clock::now();
  const auto stopped_within = [&](auto pause) {
    wake.wait_for(lock, stop, pause, [] { return false; });
    return stop.stop_requested();
  };
  if (stopped_within(1s)) return;
  do {
    std::int64_t step = step_.load(std::memory_order_relaxed);
    try {
      const v1::Session now = session_.refresh();
      for (const std::int64_t held : now.checkpoints()) {
        if (held <= to_) step = std::max(step, held);
      }
    } catch (const client::Error&) {
      // The call that this watches will say it better.
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    std::cerr << '\r' << progress_line(step, to_, static_cast<double>(step) / elapsed.count())
              << "\033[K" << std::flush;
  } while (!stopped_within(250ms));
  std::cerr << "\r\033[K" << std::flush;
}

}  // namespace stiefel::cli
