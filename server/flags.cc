#include "server/flags.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>

#include "engine/linalg/arithmetic/to_text.h"
#include "server/address.h"
#include "server/limits/memory_limit.h"

namespace stiefel::server {
namespace {

/// Refuses whatever is not one number of `low` to `high`: NaN, infinity, text after the number.
template <class Number>
CLI::Validator within(Number low, Number high, const std::string& unit) {
  const auto text = [](Number value) {
    if constexpr (std::is_integral_v<Number>)
      return std::to_string(value);
    else
      return to_text(value);
  };
  const std::string rule = unit + " of " + text(low) + " to " + text(high);
  const auto fault = [low, high, rule](const std::string& given) -> std::string {
    Number value{};
    const char* end = given.data() + given.size();
    const auto read = std::from_chars(given.data(), end, value);
    const bool whole = read.ec == std::errc() && read.ptr == end;
    return whole && low <= value && value <= high ? "" : "'" + given + "' must be " + rule;
  };
  return CLI::Validator(fault, "");
}

double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

/// Up to the next whole millisecond: what is not 0 does not become 0.
std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
}

/// Refuses what is no amount of memory.
std::string sound_memory(const std::string& given) {
  return read_bytes(given) ? ""
                           : "'" + given +
                                 "' must be a number of bytes, at least 64M, with K, M, G or T for "
                                 "powers of 1024";
}

/// CLI11 puts lists in brackets.
std::string cell(std::string text) {
  if (text.starts_with('[')) text = text.substr(1, text.size() - 2);
  return text.empty() ? "" : "`" + text + "`";
}

}  // namespace

std::string sound_address(const std::string& address) {
  const auto fault = address_fault(address);
  return fault ? address + ": " + *fault : "";
}

Flags::Flags() {
  options_.listen = {"127.0.0.1:50551"};
  options_.log_level = "info";
  idle_timeout_ = seconds(options_.idle_timeout);
  grace_ = seconds(options_.grace);
}

void Flags::add_to(CLI::App& app) {
  app.add_option("--listen", options_.listen,
                 "host:port (0: any free port) or unix:PATH; repeatable")
      ->envname("STIEFEL_LISTEN")
      ->delimiter(',')
      ->check(sound_address)
      ->capture_default_str();
  app.add_option("--threads", options_.threads, "Threads that compute; 0: one a core")
      ->envname("STIEFEL_THREADS")
      ->check(within(0, 1024, "a number"))
      ->capture_default_str();
  app.add_option("--max-sessions", options_.max_sessions, "Sessions held at once")
      ->envname("STIEFEL_MAX_SESSIONS")
      ->check(within<std::int64_t>(1, 4294967295, "a number"))
      ->capture_default_str();
  app.add_option(
         "--memory", memory_,
         "Bytes that the process may take, such as 512M or 4G; what does not fit is refused. "
         "Default: three quarters of the control group's limit, or of the machine's memory")
      ->envname("STIEFEL_MEMORY")
      ->check(sound_memory);
  app.add_option("--max-connections", options_.connections.most,
                 "Connections at once; the newest beyond it is refused. 0, and at most: the limit "
                 "of file descriptors less 96")
      ->envname("STIEFEL_MAX_CONNECTIONS")
      ->check(within<std::int64_t>(0, 1'000'000'000, "a number"))
      ->capture_default_str();
  app.add_option("--max-connection-age", max_connection_age_,
                 "Seconds after which a connection takes no new calls and its client makes a new "
                 "one, within 10 %; 0: never")
      ->envname("STIEFEL_MAX_CONNECTION_AGE")
      ->check(within(0.0, 1e6, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--idle-timeout", idle_timeout_,
                 "Seconds after which an unused session is dropped")
      ->envname("STIEFEL_IDLE_TIMEOUT")
      ->check(within(0.001, 1e9, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--grace", grace_,
                 "Seconds that running work gets when the server is told to stop; it ends at most "
                 "2 s later")
      ->envname("STIEFEL_GRACE")
      ->check(within(0.0, 1e6, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--self-watch", self_watch_,
                 "The server connects to its own addresses and ends, exit status 1, when one has "
                 "not answered for so many seconds; 0: it does not")
      ->envname("STIEFEL_SELF_WATCH")
      ->check(within(0.0, 1e6, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--log-level", options_.log_level, "What is logged on stderr")
      ->envname("STIEFEL_LOG_LEVEL")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "critical", "off"}))
      ->capture_default_str();
  app.add_option("--log-format", log_format_, "text or json")
      ->envname("STIEFEL_LOG_FORMAT")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_flag("--exit-with-parent", exit_with_parent, "Stop when stdin ends; for child processes");
}

Options Flags::options() const {
  Options options = options_;
  options.idle_timeout = milliseconds(idle_timeout_);
  options.grace = milliseconds(grace_);
  options.connections.max_age = milliseconds(max_connection_age_);
  options.connections.self_watch = milliseconds(self_watch_);
  if (!memory_.empty()) options.memory = read_bytes(memory_).value();
  options.log_json = log_format_ == "json";
  return options;
}

std::string flag_table(const CLI::App& app) {
  std::string table = "| flag | variable | default | meaning |\n| --- | --- | --- | --- |\n";
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_name() == "--help" || option->get_name() == "--version") continue;
    table += "| " + cell(option->get_name()) + " | " + cell(option->get_envname()) + " | " +
             cell(option->get_default_str()) + " | " + option->get_description() + " |\n";
  }
  return table;
}

}  // namespace stiefel::server
