#include "client/cli/progress/progress.h"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace stiefel::cli {
namespace {

std::string joined(const std::vector<std::string>& words, const Room& room) {
  std::string text;
  for (const std::string& word : words) {
    if (word.empty()) continue;
    if (!text.empty()) text += room.terminal ? "  " : ", ";
    text += word;
  }
  return text;
}

}  // namespace

std::string progress_line(std::int64_t step, std::int64_t to, double seconds, const Room& room) {
  const double fraction = to > 0 ? static_cast<double>(step) / static_cast<double>(to) : 1;
  const std::string at = "step " + std::to_string(step);
  const std::string of = at + " of " + std::to_string(to);
  char rate[32] = "0 steps/s";
  std::string eta;
  if (step > 0 && seconds > 0) {
    const double per_second = static_cast<double>(step) / seconds;
    std::snprintf(rate, sizeof rate, "%.3g steps/s", per_second);
    eta = "ETA " + duration(static_cast<double>(to - step) / per_second);
  }
  constexpr std::size_t percentage = 7;  // with its blanks
  std::string words;
  for (const auto& choice : std::vector<std::vector<std::string>>{
           {of, rate, eta}, {at, rate, eta}, {at, eta}, {eta}, {}}) {
    words = joined(choice, room);
    if (words.size() + percentage <= static_cast<std::size_t>(std::max(0, room.columns))) break;
  }
  return with_bar(fraction, words, room);
}

Progress::Progress(const client::Session& session, std::int64_t to)
    : session_(session), to_(to), line_([this](const Room& room) {
        ask();
        const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
        return progress_line(step_, to_, elapsed.count(), room);
      }) {}

void Progress::at(std::int64_t step) {
  std::int64_t known = step_;
  while (known < step && !step_.compare_exchange_weak(known, step)) {
  }
}

std::string Progress::how_far() const {
  return "at step " + std::to_string(step_) + " of " + std::to_string(to_);
}

void Progress::ask() {
  try {
    const v1::Session now = session_.refresh();
    for (const std::int64_t held : now.cached_steps()) {
      if (held <= to_) at(held);
    }
  } catch (const client::Error&) {
    // The call that this line reports on fails with a better message.
  }
}

}  // namespace stiefel::cli
