#include "server/flags.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>

#include "engine/numbers/to_text.h"
#include "server/address.h"
#include "server/limits/memory_limit.h"

namespace stiefel::server {
namespace {

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

double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

/// Rounds up to whole milliseconds, so that only 0 becomes 0.
std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::ceil<std::chrono::milliseconds>(std::chrono::duration<double>(seconds));
}

/// Returns the rule that the text breaks as the process's memory, at least 64 MiB; empty if none.
std::string memory_error(const std::string& given) {
  return read_bytes(given) ? ""
                           : "'" + given +
                                 "' must be a number of bytes, at least 64M, with K, M, G or T for "
                                 "powers of 1024";
}

/// Returns the rule that the text breaks as a part of that memory; empty if none.
std::string memory_part_error(const std::string& given) {
  return read_bytes(given, 0)
             ? ""
             : "'" + given + "' must be a number of bytes, with K, M, G or T for powers of 1024";
}

/// Returns a default as a cell of the table; CLI11 puts lists in brackets.
std::string cell(std::string text) {
  if (text.starts_with('[')) text = text.substr(1, text.size() - 2);
  return text.empty() ? "" : "`" + text + "`";
}

/// The limits of each principal.
void add_quota_to(CLI::App& app, Quota& quota) {
  const auto add = [&app]<class Number>(const char* flag, const char* variable, Number& value,
                                        const char* meaning) {
    const auto range = [] {
      if constexpr (std::is_integral_v<Number>)
        return within<std::int64_t>(0, 1'000'000'000, "a number");
      else
        return within(0.0, 1e18, "a number of instructions");
    };
    app.add_option(flag, value, std::string(meaning) + "; 0: no limit")
        ->envname(variable)
        ->check(range())
        ->capture_default_str();
  };
  app.add_option("--principal-sessions", quota.sessions,
                 "Largest number of sessions of one principal; 0: no limit. Default: with --tokens "
                 "half of --max-sessions, otherwise no limit")
      ->envname("STIEFEL_PRINCIPAL_SESSIONS")
      ->check(within<std::int64_t>(0, 1'000'000'000, "a number"));
  add("--principal-streams", "STIEFEL_PRINCIPAL_STREAMS", quota.streams,
      "Largest number of open Streams and Drives of one principal");
  add("--principal-calls", "STIEFEL_PRINCIPAL_CALLS", quota.calls,
      "Largest number of other calls of one principal that compute or wait for a thread");
  add("--principal-work-rate", "STIEFEL_PRINCIPAL_WORK_RATE", quota.work_a_second,
      "Instructions a second that the calls of one principal may execute");
  add("--principal-queued-work", "STIEFEL_PRINCIPAL_QUEUED_WORK", quota.queued_work,
      "Sum of the prices of one principal's running and waiting calls, in instructions");
  add("--max-call-work", "STIEFEL_MAX_CALL_WORK", quota.call_work,
      "Largest price of one call, in instructions");
}

}  // namespace

std::string address_error(const std::string& address) {
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
      ->check(address_error)
      ->capture_default_str();
  app.add_option("--threads", options_.threads, "Threads that compute; 0: one for each core")
      ->envname("STIEFEL_THREADS")
      ->check(within(0, 1024, "a number"))
      ->capture_default_str();
  app.add_option("--max-sessions", options_.max_sessions, "Largest number of sessions")
      ->envname("STIEFEL_MAX_SESSIONS")
      ->check(within<std::int64_t>(1, 4294967295, "a number"))
      ->capture_default_str();
  app.add_option(
         "--memory", memory_,
         "Memory limit of the process in bytes, such as 512M or 4G; a session or call that does "
         "not fit is refused. Default: three quarters of the control group's limit or, without "
         "one, of the machine's memory")
      ->envname("STIEFEL_MEMORY")
      ->check(memory_error);
  app.add_option("--max-connections", options_.connections.most,
                 "Largest number of connections; a further one is refused. 0: the limit of file "
                 "descriptors minus 96, which is also the upper bound")
      ->envname("STIEFEL_MAX_CONNECTIONS")
      ->check(within<std::int64_t>(0, 1'000'000'000, "a number"))
      ->capture_default_str();
  app.add_option(
         "--max-connection-age", max_connection_age_,
         "Age in seconds, varied by up to 10 %, at which a connection accepts no new calls, "
         "so that its client opens another; 0: none")
      ->envname("STIEFEL_MAX_CONNECTION_AGE")
      ->check(within(0.0, 1e6, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--idle-timeout", idle_timeout_,
                 "Seconds after which an unused session is dropped")
      ->envname("STIEFEL_IDLE_TIMEOUT")
      ->check(within(0.001, 1e9, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--grace", grace_,
                 "Seconds that running calls may take after SIGTERM; the process ends at most 2 s "
                 "after them")
      ->envname("STIEFEL_GRACE")
      ->check(within(0.0, 1e6, "a number of seconds"))
      ->capture_default_str();
  app.add_option("--self-watch", self_watch_,
                 "Seconds without an answer from one of the server's own addresses after which the "
                 "server exits with status 1; 0: it never checks")
      ->envname("STIEFEL_SELF_WATCH")
      ->check(within(0.0, 1e6, "a number of seconds"))
      ->capture_default_str();
  add_quota_to(app, options_.quota);
  app.add_option(
         "--principal-memory", principal_memory_,
         "Largest number of bytes that the sessions and calls of one principal hold, such as 512M; "
         "0: no limit. Default: with --tokens half of what --memory leaves for sessions and calls, "
         "otherwise no limit")
      ->envname("STIEFEL_PRINCIPAL_MEMORY")
      ->check(memory_part_error);
  app.add_option("--store", options_.store.file,
                 "File in which sessions survive the end of the server, also a crash; empty: "
                 "sessions are in memory only")
      ->envname("STIEFEL_STORE")
      ->capture_default_str();
  app.add_option("--store-limit", options_.store.limit,
                 "Largest size of the store in bytes, without its log; 0: the space on the disk")
      ->envname("STIEFEL_STORE_LIMIT")
      ->check(within<std::int64_t>(0, std::int64_t{1} << 46, "a number of bytes"))
      ->capture_default_str();
  add_access_to(app);
  app.add_option("--metrics", options_.metrics,
                 "host:port (0: any free port) at which Prometheus reads /metrics without a token, "
                 "over HTTP, with --tls-cert over HTTPS. Empty: no metrics")
      ->envname("STIEFEL_METRICS")
      ->check(address_error)
      ->capture_default_str();
  app.add_option("--log-level", options_.log_level, "Least severe level that is logged on stderr")
      ->envname("STIEFEL_LOG_LEVEL")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "critical", "off"}))
      ->capture_default_str();
  app.add_option("--log-format", log_format_, "Format of the log: text or json")
      ->envname("STIEFEL_LOG_FORMAT")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  app.add_flag("--exit-with-parent", exit_with_parent,
               "Stops the server when its stdin ends; for child processes");
}

void Flags::add_access_to(CLI::App& app) {
  AccessOptions& access = options_.access;
  const auto add_file = [&](const char* flag, const char* variable, std::string& file,
                            const char* meaning) {
    app.add_option(flag, file, meaning)->envname(variable)->type_name("FILE");
  };
  add_file("--tls-cert", "STIEFEL_TLS_CERT", access.tls.certificate,
           "The server's certificate and its chain in PEM. The server then uses TLS on all TCP "
           "addresses. --tls-cert, --tls-key and --tls-client-ca are reread when they change");
  add_file("--tls-key", "STIEFEL_TLS_KEY", access.tls.key, "The certificate's private key in PEM");
  add_file("--tls-client-ca", "STIEFEL_TLS_CLIENT_CA", access.tls.client_ca,
           "Authorities in PEM; a client must present a certificate that one of them signed");
  add_file(
      "--tokens", "STIEFEL_TOKENS", access.tokens,
      "File of the tokens that may call, one line each, as `stiefel-server token NAME` prints it. "
      "Reread when it changes. Default: every client that can connect may call");
  add_file("--checkpoint-key", "STIEFEL_CHECKPOINT_KEY", access.checkpoint_key,
           "File of checkpoint keys, one of 64 hexadecimal digits per line. The first key signs, "
           "every key verifies. Servers with the same file accept each other's checkpoints. "
           "Default: a random key");
  app.add_flag("--insecure", access.insecure,
               "Allows addresses without TLS that other machines can reach")
      ->envname("STIEFEL_INSECURE");
}

Options Flags::options() const {
  Options options = options_;
  options.idle_timeout = milliseconds(idle_timeout_);
  options.grace = milliseconds(grace_);
  options.connections.max_age = milliseconds(max_connection_age_);
  options.connections.self_watch = milliseconds(self_watch_);
  if (!memory_.empty()) options.memory = read_bytes(memory_).value();
  if (!principal_memory_.empty()) options.quota.memory = read_bytes(principal_memory_, 0).value();
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
