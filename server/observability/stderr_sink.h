#pragma once

#include <spdlog/sinks/base_sink.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace stiefel::server {

/// Writes text to stderr unless that would block for longer than `wait` milliseconds: on a pipe
/// that nobody reads. Returns whether all of it is written.
bool write_stderr(std::string_view text, int wait);

/// Writes lines to stderr without blocking the service for long. If stderr is a pipe whose reader
/// does not read, waits at most `patience` for it, then drops lines until it reads again, and then
/// writes a line with their number. After a drop it does not wait for `trust`.
class StderrSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static constexpr int patience = 100;  ///< milliseconds
  static constexpr std::chrono::seconds trust{10};
  /// Returns the text of the line that reports the number of dropped lines.
  using Told = std::function<std::string(std::uint64_t dropped)>;
  explicit StderrSink(Told told) : told_(std::move(told)) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

  bool write_line(const spdlog::details::log_msg& message, int wait);

  const Told told_;
  std::uint64_t dropped_ = 0;  // lines dropped since one was written
  std::optional<std::chrono::steady_clock::time_point> last_drop_;
};

}  // namespace stiefel::server
