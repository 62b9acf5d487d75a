#pragma once

#include <spdlog/sinks/base_sink.h>

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace stiefel::server {

/// Lines on stderr that never block the service for long. Where stderr is a pipe whose reader does
/// not read, a line waits for it for at most `patience`; then lines are dropped until the reader
/// reads again, which a line with their number tells.
class StderrSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  static constexpr int patience = 100;  ///< milliseconds
  /// What the line says that tells how many were dropped.
  using Told = std::function<std::string(std::uint64_t dropped)>;
  explicit StderrSink(Told told) : told_(std::move(told)) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

  bool write_line(const spdlog::details::log_msg& message, int wait);

  const Told told_;
  std::uint64_t dropped_ = 0;  // lines since one was written
};

}  // namespace stiefel::server
