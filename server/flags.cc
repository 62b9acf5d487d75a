#include "server/flags.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>

#include "engine/linalg/arithmetic/to_text.h"
#include "server/address.h"
#include "server/limits/memory_limit.h"

namespace stiefel::server {
namespace {

/// Accepts one number of `low` to `high`; refuses NaN, infinity and text after the number.
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
  add("--principal-sessions", "STIEFEL_PRINCIPAL_SESSIONS", quota.sessions,
      "Sessions that one principal holds at once");
  add("--principal-streams", "STIEFEL_PRINCIPAL_STREAMS", quota.streams,
      "Streams and Drives that one principal has open at once");
  add("--principal-calls", "STIEFEL_PRINCIPAL_CALLS", quota.calls,
      "Other calls of one principal that compute or wait for a worker");
  add("--principal-work-rate", "STIEFEL_PRINCIPAL_WORK_RATE", quota.work_a_second,
      "Work a second of one principal, in instructions");
  add("--principal-queued-work", "STIEFEL_PRINCIPAL_QUEUED_WORK", quota.queued_work,
      "The prices of all calls of one principal that run or wait, in instructions");
  add("--max-call-work", "STIEFEL_MAX_CALL_WORK", quota.call_work,
      "The largest price of one call, in instructions");
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
      ->check(memory_error);
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
  add_quota_to(app, options_.quota);
  app.add_option(
         "--principal-memory", principal_memory_,
         "Bytes that the sessions and calls of one principal hold at once, such as 512M; 0: "
         "no limit")
      ->envname("STIEFEL_PRINCIPAL_MEMORY")
      ->check(memory_part_error)
      ->capture_default_str();
  app.add_option("--store", options_.store.file,
                 "File that keeps the sessions when the server ends, however it ends; empty: they "
                 "live in memory and end with it")
      ->envname("STIEFEL_STORE")
      ->capture_default_str();
  app.add_option("--store-limit", options_.store.limit,
                 "The store's largest size in bytes, without its log; 0: as much as the disk has")
      ->envname("STIEFEL_STORE_LIMIT")
      ->check(within<std::int64_t>(0, std::int64_t{1} << 46, "a number of bytes"))
      ->capture_default_str();
  add_access_to(app);
  app.add_option("--metrics", options_.metrics,
                 "host:port where Prometheus reads metrics over HTTP, at /metrics (0: any free "
                 "port); over HTTPS where --tls-cert is given, without tokens. Empty: nowhere")
      ->envname("STIEFEL_METRICS")
      ->check(address_error)
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

void Flags::add_access_to(CLI::App& app) {
  AccessOptions& access = options_.access;
  const auto add_file = [&](const char* flag, const char* variable, std::string& file,
                            const char* meaning) {
    app.add_option(flag, file, meaning)->envname(variable)->type_name("FILE");
  };
  add_file("--tls-cert", "STIEFEL_TLS_CERT", access.tls.certificate,
           "The server's certificate and its chain in PEM: TLS on every address but Unix sockets. "
           "Read again when it changes, as the two files after it are");
  add_file("--tls-key", "STIEFEL_TLS_KEY", access.tls.key, "The certificate's private key in PEM");
  add_file("--tls-client-ca", "STIEFEL_TLS_CLIENT_CA", access.tls.client_ca,
           "Authorities in PEM; a client must have a certificate of one of them");
  add_file(
      "--tokens", "STIEFEL_TOKENS", access.tokens,
      "Who may call: a line for each token, as `stiefel-server token NAME` prints it. Read again "
      "when it changes. Without it whoever can connect may call");
  add_file("--checkpoint-key", "STIEFEL_CHECKPOINT_KEY", access.checkpoint_key,
           "Keys that authenticate checkpoints, 64 hexadecimal digits a line: the first signs, all "
           "verify. Servers that share it take each other's checkpoints. Without it a random key");
  app.add_flag("--insecure", access.insecure,
               "Allows addresses that other machines reach without TLS")
      ->envname("STIEFEL_INSECURE");
}

Options Flags::options() const {
  Options options = options_;
  options.idle_timeout = milliseconds(idle_timeout_);
  options.grace = milliseconds(grace_);
  options.connections.max_age = milliseconds(max_connection_age_);
  options.connections.self_watch = milliseconds(self_watch_);
  if (!memory_.empty()) options.memory = read_bytes(memory_).value();
  options.quota.memory = read_bytes(principal_memory_, 0).value();
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
