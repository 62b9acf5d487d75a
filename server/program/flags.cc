#include "server/program/flags.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "engine/numbers/to_text.h"
#include "engine/scene/near_name.h"
#include "server/connections/listener.h"
#include "server/scheduling/memory_limit.h"

namespace stiefel::server {
namespace {

/// Accepts one number from `low` to `high`; refuses NaN, infinity and text after the number.
CLI::Validator within(double low, double high, const std::string& unit) {
  const auto fault = [=](const std::string& given) -> std::string {
    double value = 0;
    const char* end = given.data() + given.size();
    const auto read = std::from_chars(given.data(), end, value);
    if (read.ec == std::errc() && read.ptr == end && low <= value && value <= high) return "";
    return "'" + given + "' must be " + unit + " from " + to_text(low) + " to " + to_text(high);
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
  const auto fault = [least](const std::string& given) -> std::string {
    if (read_bytes(given, least)) return "";
    return "'" + given + "' must be a number of bytes" + (least > 0 ? ", at least 64M" : "") +
           ", with K, M, G or T for powers of 1024";
  };
  const auto set = [&value](const std::string& given) { value = *read_bytes(given, 0); };
  app.add_option_function<std::string>(flag, set, meaning)->check(CLI::Validator(fault, ""));
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

/// Returns the rule that the address breaks, which CLI11 puts after "--listen: "; empty if none.
std::string address_error(const std::string& address) {
  const auto fault = address_fault(address);
  return fault ? address + ": " + *fault : "";
}

/// Whether Kubernetes sets the variable: STIEFEL_SERVICE_HOST=10.0.0.1,
/// STIEFEL_PORT=tcp://10.0.0.1:50551, STIEFEL_PROXY_PORT_50551_TCP_ADDR=10.0.0.1.
bool of_kubernetes(std::string_view name, std::string_view value) {
  return name.find("_SERVICE_") != name.npos || name.find("_PORT_") != name.npos ||
         value.find("://") != value.npos;
}

std::vector<CLI::Option*> options_of(CLI::App& app) {
  return app.get_options([](const CLI::Option*) { return true; });
}

}  // namespace

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
      ->check(within(1, 4294967295, "a number"));
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
      ->check(within(0, 1e9, "a number"))
      ->default_str("");
  app.add_option("--max-call-seconds", options.quota.call_seconds,
                 "Seconds for which one call, or one request of a Drive, may compute; 0: no limit")
      ->check(within(0, 1e9, "a number of seconds"));
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

void check_variables(CLI::App& app) {
  for (CLI::Option* option : options_of(app)) {
    const std::string& name = option->get_envname();
    const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
    if (value == nullptr || *value == '\0' || option->count() > 0) continue;
    std::string text = value;
    throw CLI::ValidationError(name, (*option->get_validator())(text));
  }
}

std::vector<std::string> unknown_variables(CLI::App& app) {
  // Those of the clients, and of the tests.
  std::vector<std::string> known = {"STIEFEL_ADDRESS", "STIEFEL_SERVER", "STIEFEL_TLS_CA",
                                    "STIEFEL_TOKEN",   "STIEFEL_CLI",    "STIEFEL_SANITIZED"};
  for (const CLI::Option* option : options_of(app)) known.push_back(option->get_envname());
  std::vector<std::string> sentences;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::size_t equals = std::min(text.find('='), text.size());
    const std::string name(text.substr(0, equals));
    if (!name.starts_with("STIEFEL_") || std::ranges::find(known, name) != known.end() ||
        of_kubernetes(name, text.substr(equals)))
      continue;
    const auto near = near_name(name, known);
    sentences.push_back(name + ": unknown variable" +
                        (near ? "; did you mean " + *near + "?" : ""));
  }
  std::ranges::sort(sentences);
  return sentences;
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
