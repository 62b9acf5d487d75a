#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace spdlog {
class logger;
}

namespace stiefel::server {

/// Limits lines of one kind to `most` a second, and counts those that are left out. Thread-safe.
class LineRate {
 public:
  static constexpr int most = 10;
  using Clock = std::chrono::steady_clock;

  /// Returns whether a line may be written now.
  bool take(Clock::time_point now = Clock::now()) {
    const std::lock_guard lock(mutex_);
    if (now - begin_ >= std::chrono::seconds(1)) {
      begin_ = now;
      lines_ = 0;
    }
    if (lines_ < most) return ++lines_, true;
    ++left_out_;
    return false;
  }
  /// Returns the number of lines that were left out since the last call.
  std::int64_t take_left_out() {
    const std::lock_guard lock(mutex_);
    const std::int64_t count = left_out_;
    left_out_ = 0;
    return count;
  }

 private:
  std::mutex mutex_;
  Clock::time_point begin_;  // of the second; guarded by mutex_, as are the members below
  int lines_ = 0;            // in it
  std::int64_t left_out_ = 0;
};

/// Writes lines to stderr, as text or as JSON. Formats nothing below its level.
class Log {
 public:
  enum class Level { debug, info, warn, error };
  using Value = std::variant<std::string, std::int64_t, double>;
  using Fact = std::pair<const char*, Value>;
  using Facts = std::vector<Fact>;

  /// Throws std::runtime_error for an unknown level.
  Log(const std::string& level, bool json);
  ~Log();

  bool enabled(Level level) const;
  void line(Level level, std::string_view message, const Facts& facts = {}) const;

  /// Counts a call without a line of its own. At most every `counted_together` a line tells the
  /// numbers of such calls, and `tell_counted` writes it at once if there are any.
  void count(bool failed) const;
  void tell_counted() const;
  static constexpr std::chrono::seconds counted_together{60};
  /// Whether a short call that failed has a line of its own: ten a second have.
  bool tells_failure() const { return failures_.take(); }

 private:
  using Clock = std::chrono::steady_clock;

  std::unique_ptr<spdlog::logger> logger_;
  bool json_;
  mutable LineRate failures_;
  mutable std::atomic<std::int64_t> counted_ = 0, counted_failed_ = 0;
  mutable std::atomic<Clock::time_point> last_told_ = Clock::now();
};

/// Sends the lines that gRPC itself logs, in the whole process, to a log while the object lives: at
/// most ten a second, with the message "grpc". A caller can cause such lines, and gRPC's own
/// writing would wait for the reader of stderr with the threads that serve connections. A process
/// has one.
class GrpcLog {
 public:
  /// The log must outlive this object.
  explicit GrpcLog(const Log& log);
  ~GrpcLog();
  GrpcLog(const GrpcLog&) = delete;
  GrpcLog& operator=(const GrpcLog&) = delete;
};

}  // namespace stiefel::server
