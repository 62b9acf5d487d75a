#include "server/program/flags.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "engine/numbers/to_text.h"
#include "server/connections/listener.h"
#include "server/scheduling/memory_limit.h"

namespace stiefel::server {
namespace {

constexpr std::int64_t billion = 1'000'000'000;

/// Accepts one number from `low` to `high`; refuses NaN, infinity and text after the number.
template <class Number>
CLI::Validator within(Number low, Number high, const std::string& unit) {
  const auto text = [](Number value) {
    if constexpr (std::is_integral_v<Number>) {
      return std::to_string(value);
    } else {
      const bool whole = value == std::floor(value) && value < 1e10;
      return whole ? std::to_string(static_cast<std::int64_t>(value)) : to_text(value);
    }
  };
  const std::string rule = unit + " from " + text(low) + " to " + text(high);
  const auto fault = [low, high, rule](const std::string& given) -> std::string {
    Number value{};
    const char* end = given.data() + given.size();
    const auto read = std::from_chars(given.data(), end, value);
    const bool whole = read.ec == std::errc() && read.ptr == end;
    return whole && low <= value && value <= high ? "" : "'" + given + "' must be " + rule;
  };
  return CLI::Validator(fault, "");
}

/// Accepts a number of bytes that is at least `least`.
CLI::Validator bytes(std::uint64_t least) {
  const auto fault = [least](const std::string& given) -> std::string {
    if (read_bytes(given, least)) return "";
    return "'" + given + "' must be a number of bytes" + (least > 0 ? ", at least 64M" : "") +
           ", with K, M, G or T for powers of 1024";
  };
  return CLI::Validator(fault, "");
}

/// Adds a flag for a time from `low` to `high` seconds, rounded up to whole milliseconds, so that
/// only 0 becomes 0.
void add_seconds(CLI::App& app, const char* flag, std::chrono::milliseconds& time, double low,
                 double high, const char* meaning) {
  const auto set = [&time](double seconds) {
    time = std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
  };
  app.add_option_function<double>(flag, set, meaning)
      ->check(within(low, high, "a number of seconds"))
      ->default_str(to_text(std::chrono::duration<double>(time).count()));
}

/// Adds a flag for a number of bytes, at least `least`.
template <class Bytes>
void add_bytes(CLI::App& app, const char* flag, Bytes& value, std::uint64_t least,
               const char* meaning) {
  const auto set = [&value](const std::string& given) { value = *read_bytes(given, 0); };
  app.add_option_function<std::string>(flag, set, meaning)->check(bytes(least));
}

void add_access_to(CLI::App& app, AccessOptions& access) {
  const auto add_file = [&](const char* flag, std::string& file, const char* meaning) {
    app.add_option(flag, file, meaning)->type_name("FILE");
  };
  add_file("--tls-cert", access.tls.certificate,
           "The server's certificate and its chain in PEM. The server then uses TLS on all TCP "
           "addresses. --tls-cert, --tls-key and --tls-client-ca are reread when they change");
  add_file("--tls-key", access.tls.key, "The certificate's private key in PEM");
  add_file("--tls-client-ca", access.tls.client_ca,
           "Authorities in PEM; a client must present a certificate that one of them signed");
  add_file(
      "--tokens", access.tokens,
      "File of the tokens that may call, one line each, as `stiefel-server token NAME` prints it. "
      "Reread when it changes. Default: every client that can connect may call");
  app.add_flag("--insecure", access.insecure,
               "Allows addresses without TLS that other machines can reach");
}

/// Returns a default as a cell of the table; CLI11 puts lists in brackets.
std::string cell(std::string text) {
  if (text.starts_with('[')) text = text.substr(1, text.size() - 2);
  return text.empty() ? "" : "`" + text + "`";
}

/// Returns the variable of a flag: STIEFEL_MAX_SESSIONS of max-sessions.
std::string variable_of(std::string flag) {
  std::ranges::transform(flag, flag.begin(), [](unsigned char c) {
    return c == '-' ? '_' : static_cast<char>(std::toupper(c));
  });
  return "STIEFEL_" + flag;
}

}  // namespace

std::string address_error(const std::string& address) {
  const auto fault = address_fault(address);
  return fault ? address + ": " + *fault : "";
}

Flags::Flags(CLI::App& app) {
  options.listen = {"127.0.0.1:50551"};
  options.log_level = "info";
  app.option_defaults()->always_capture_default();
  app.add_option("--listen", options.listen,
                 "host:port (0: any free port) or unix:PATH; repeatable")
      ->delimiter(',')
      ->check(address_error);
  app.add_option("--threads", options.threads, "Threads that compute; 0: one for each core")
      ->check(within(0, 1024, "a number"));
  app.add_option("--max-sessions", options.max_sessions, "Largest number of sessions")
      ->check(within<std::int64_t>(1, 4294967295, "a number"));
  add_bytes(app, "--memory", options.memory, least_memory,
            "Memory limit of the process in bytes, such as 512M or 4G; a session or call that does "
            "not fit is refused. Default: three quarters of the control group's limit or, without "
            "one, of the machine's memory");
  add_seconds(app, "--max-connection-age", options.connections.max_age, 0, 1e6,
              "Age in seconds, varied by up to 10 %, at which a connection accepts no new calls, "
              "so that its client opens another; 0: none");
  add_seconds(app, "--idle-timeout", options.idle_timeout, 0.001, 1e9,
              "Seconds after which an unused session is dropped");
  add_seconds(app, "--grace", options.grace, 0, 1e6,
              "Seconds that running calls may take after SIGTERM; the process ends at most 2 s "
              "after them");
  app.add_option("--principal-sessions", options.quota.sessions,
                 "Largest number of sessions of one principal; 0: no limit. Default: with --tokens "
                 "half of --max-sessions, otherwise no limit")
      ->check(within<std::int64_t>(0, billion, "a number"))
      ->default_str("");
  app.add_option("--max-call-seconds", options.quota.call_seconds,
                 "Seconds for which one call, or one request of a Drive, may compute; 0: no limit")
      ->check(within(0.0, 1e9, "a number of seconds"));
  add_bytes(app, "--principal-memory", options.quota.memory, 0,
            "Largest number of bytes that the sessions and calls of one principal hold, such as "
            "512M; 0: no limit. Default: with --tokens half of what --memory leaves for sessions "
            "and calls, otherwise no limit");
  app.add_option("--store", options.store,
                 "File in which sessions survive the end of the server, also a crash; empty: "
                 "sessions are in memory only");
  add_access_to(app, options.access);
  app.add_option("--metrics", options.metrics,
                 "host:port (0: any free port) at which Prometheus reads /metrics without a token, "
                 "over plain HTTP. Empty: no metrics")
      ->check(address_error);
  app.add_option("--log-level", options.log_level, "Least severe level that is logged on stderr")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "critical", "off"}));
  app.add_option_function<std::string>(
         "--log-format", [this](const std::string& format) { options.log_json = format == "json"; },
         "Format of the log: text or json")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text");
  for (CLI::Option* flag : app.get_options([](const CLI::Option* one) {
         return one->get_name() != "--help" && one->get_name() != "--version";
       }))
    flag->envname(variable_of(flag->get_lnames().front()));
  app.option_defaults()->always_capture_default(false);
  app.add_flag("--exit-with-parent", exit_with_parent,
               "Stops the server when its stdin ends; for child processes");
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
