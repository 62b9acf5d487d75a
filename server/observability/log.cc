#include "server/observability/log.h"

#include <spdlog/async_logger.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string_view>

namespace stiefel::server {
namespace {

spdlog::level::level_enum to_spdlog(Log::Level level) {
  switch (level) {
    case Log::Level::debug:
      return spdlog::level::debug;
    case Log::Level::info:
      return spdlog::level::info;
    case Log::Level::warn:
      return spdlog::level::warn;
    case Log::Level::error:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

std::string as_json(std::string_view message, const Log::Facts& facts) {
  nlohmann::ordered_json line{{"message", message}};
  for (const auto& [key, value] : facts) {
    std::visit([&, name = key](const auto& x) { line[name] = x; }, value);
  }
  // Leaves out the opening brace: the pattern puts it before the time and the level.
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).substr(1);
}

std::string as_text(std::string_view message, const Log::Facts& facts) {
  std::string line(message);
  for (const auto& [key, value] : facts) {
    line += fmt::format(" {}=", key);
    if (const auto* text = std::get_if<std::string>(&value)) {
      // Quotes the text, so that what a caller sends cannot look like another line.
      line += nlohmann::json(*text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    } else {
      std::visit([&](const auto& x) { line += fmt::format("{}", x); }, value);
    }
  }
  return line;
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
      json ? R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v)" : "%Y-%m-%dT%H:%M:%S.%eZ %l %v",
      spdlog::pattern_time_type::utc);
}

Log::~Log() = default;

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
  logger_->log(to_spdlog(level), "{}", json_ ? as_json(message, facts) : as_text(message, facts));
}

}  // namespace stiefel::server
