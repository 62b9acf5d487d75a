#include "client/cli/progress/status_line.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <iostream>
#include <mutex>

namespace stiefel::cli {
namespace {

using namespace std::chrono_literals;

constexpr int widest = 79, widest_bar = 30, least_bar = 4;
constexpr const char* prefix = "stiefel: ";

/// Returns the columns that a line may use. The last column of a terminal stays free, because some
/// terminals start a new line after a character there.
int columns_of_terminal() {
  winsize size = {};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return known ? std::min(widest, size.ws_col - 1) : widest;
}

void rewrite(const std::function<std::string(const Room&)>& text,
             const std::function<bool(std::chrono::milliseconds)>& stopped_within) {
  bool written = false;
  for (auto waited = 0ms; !stopped_within(250ms);) {
    const std::string line = text({columns_of_terminal(), true});
    if ((waited += 250ms) < 1s || line.empty()) continue;
    std::cerr << '\r' << line << "\033[K" << std::flush;
    written = true;
  }
  if (written) std::cerr << "\r\033[K" << std::flush;
}

void append(const std::function<std::string(const Room&)>& text,
            const std::function<bool(std::chrono::milliseconds)>& stopped_within) {
  const Room room{widest - static_cast<int>(std::string(prefix).size()), false};
  for (int seconds = 1; !stopped_within(1s); ++seconds) {
    const std::string line = text(room);
    if (seconds % 10 == 0 && !line.empty()) std::cerr << prefix + line + '\n' << std::flush;
  }
}

}  // namespace

StatusLine::StatusLine(Text text) : text_(std::move(text)) {
  writer_ = std::jthread([this](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any wake;
    std::unique_lock lock(mutex);
    auto next = std::chrono::steady_clock::now();
    const auto stopped_within = [&](std::chrono::milliseconds pause) {
      next = std::max(next + pause, std::chrono::steady_clock::now());
      wake.wait_until(lock, stop, next, [] { return false; });
      return stop.stop_requested();
    };
    (isatty(STDERR_FILENO) ? rewrite : append)(text_, stopped_within);
  });
}

ElapsedLine::ElapsedLine(std::string what)
    : line_([what = std::move(what), start = std::chrono::steady_clock::now()](const Room& room) {
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
        return cut(what + ", " + duration(elapsed.count()), room.columns);
      }) {}

std::string duration(double seconds) {
  char text[32];
  const double days = seconds / 86400, years = days / 365.25;
  if (years >= 100) {
    std::snprintf(text, sizeof text, "%.1g years", years);
  } else if (days >= 3) {
    std::snprintf(text, sizeof text, "%.0f days", days);
  } else {
    const int whole = static_cast<int>(seconds + 0.5);
    const int h = whole / 3600, m = whole / 60 % 60, s = whole % 60;
    if (h > 0)
      std::snprintf(text, sizeof text, "%d:%02d:%02d", h, m, s);
    else
      std::snprintf(text, sizeof text, "%d:%02d", m, s);
  }
  return text;
}

std::string with_bar(double fraction, const std::string& words, const Room& room) {
  const double part = std::clamp(fraction, 0.0, 1.0);
  char percent[16];
  std::snprintf(percent, sizeof percent, room.terminal ? "%3d %%" : "%d %%",
                static_cast<int>(part * 100));
  std::string line = percent;
  if (!words.empty()) line.append(room.terminal ? "  " : ", ").append(words);
  const int left = room.columns - static_cast<int>(line.size()) - 3;
  if (!room.terminal || left < least_bar) return cut(line, room.columns);
  const int length = std::min(left, widest_bar), filled = static_cast<int>(part * length);
  std::string bar(static_cast<std::size_t>(length), ' ');
  std::fill_n(bar.begin(), filled, '=');
  return bar.insert(0, 1, '[').append("] ").append(line);
}

std::string cut(const std::string& text, int columns) {
  constexpr int dots = 3;
  const auto starts = [](char c) { return (c & 0xc0) != 0x80; };
  if (std::ranges::count_if(text, starts) <= columns) return text;
  std::string out;
  for (int width = 0; const char c : text) {
    if (starts(c) && ++width > std::max(0, columns - dots)) break;
    out += c;
  }
  return out + std::string(std::min(dots, std::max(0, columns)), '.');
}

}  // namespace stiefel::cli
