#include "server/connections/log.h"

#include <spdlog/async_logger.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace stiefel::server {
namespace {

static_assert(static_cast<int>(Log::Level::debug) == spdlog::level::debug &&
              static_cast<int>(Log::Level::error) == spdlog::level::err);

spdlog::level::level_enum to_spdlog(Log::Level level) {
  return static_cast<spdlog::level::level_enum>(level);
}

/// Returns a value as JSON: what a caller sends, in quotes, cannot look like another line.
template <class Value>
std::string as_json(const Value& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

Log::Log(const std::string& level, bool json) : json_(json) {
  thread_ = std::make_shared<spdlog::details::thread_pool>(
      longest_queue, 1, [] { pthread_setname_np(pthread_self(), "log"); });
  logger_ = std::make_shared<spdlog::async_logger>(
      "stiefel", std::make_shared<spdlog::sinks::stderr_sink_mt>(), thread_,
      spdlog::async_overflow_policy::overrun_oldest);
  const auto parsed = spdlog::level::from_str(level);
  if (parsed == spdlog::level::off && level != "off") {
    throw std::runtime_error("log level: '" + level +
                             "': must be trace, debug, info, warn, error, critical or off");
  }
  logger_->set_level(parsed);
  logger_->set_pattern(
      json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v})" : "%Y-%m-%dT%H:%M:%S.%eZ %l %v",
      spdlog::pattern_time_type::utc);
}

bool Log::enabled(Level level) const { return logger_->should_log(to_spdlog(level)); }

void Log::line(Level level, std::string_view message, const Facts& facts) const {
  if (!enabled(level)) return;
  try {
    write(level, message, facts);
    // Once lines are no longer lost, so that the telling displaces none.
    const std::size_t lost = thread_->overrun_counter();
    if (lost != seen_.exchange(lost)) return;
    if (const std::size_t told = told_.exchange(lost); told < lost)
      write(Level::warn, "log lines were dropped: nobody read stderr",
            {{"count", static_cast<std::int64_t>(lost - told)}});
  } catch (const std::exception&) {  // a call does not fail for a log line
  }
}

void Log::write(Level level, std::string_view message, const Facts& facts) const {
  std::string line = json_ ? "\"message\":" + as_json(message) : std::string(message);
  for (const auto& [key, value] : facts)
    line += fmt::format(fmt::runtime(json_ ? ",\"{}\":{}" : " {}={}"), key,
                        std::visit([](const auto& x) { return as_json(x); }, value));
  logger_->log(to_spdlog(level), "{}", line);
}

}  // namespace stiefel::server
