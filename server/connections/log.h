#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace spdlog {
class logger;
namespace details {
class thread_pool;
}
}  // namespace spdlog

namespace stiefel::server {

/// Writes lines to stderr, as text or as JSON, on a thread of its own. While nobody reads stderr
/// the newest lines replace the oldest that wait; a later line tells how many were lost. Formats
/// nothing below its level. Thread-safe.
class Log {
 public:
  enum class Level { debug = 1, info, warn, error };  ///< those of spdlog
  using Value = std::variant<std::string, std::int64_t, double>;
  using Facts = std::vector<std::pair<const char*, Value>>;

  /// Throws std::runtime_error for an unknown level.
  Log(const std::string& level, bool json);

  bool enabled(Level level) const;
  void line(Level level, std::string_view message, const Facts& facts = {}) const;

  /// The lines that wait for the writing thread.
  static constexpr std::size_t longest_queue = 1024;

 private:
  void write(Level level, std::string_view message, const Facts& facts) const;

  std::shared_ptr<spdlog::details::thread_pool> thread_;
  std::shared_ptr<spdlog::logger> logger_;
  bool json_;
  mutable std::atomic<std::size_t> seen_ = 0, told_ = 0;  // lost lines
};

}  // namespace stiefel::server
