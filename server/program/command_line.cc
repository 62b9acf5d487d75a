#include "server/program/command_line.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <regex>
#include <string_view>
#include <vector>

#include "engine/scene/near_name.h"

namespace stiefel::server {
namespace {

constexpr std::string_view prefix = "STIEFEL_";

/// The names after the prefix. The server's are those of `stiefel-server flags`.
constexpr std::array known_variables = {
    // of the server
    "GRACE", "IDLE_TIMEOUT", "INSECURE", "LISTEN", "LOG_FORMAT", "LOG_LEVEL", "MAX_CALL_SECONDS",
    "MAX_CONNECTION_AGE", "MAX_SESSIONS", "MEMORY", "METRICS", "PRINCIPAL_MEMORY",
    "PRINCIPAL_SESSIONS", "STORE", "THREADS", "TLS_CERT", "TLS_CLIENT_CA", "TLS_KEY", "TOKENS",
    // of the clients
    "ADDRESS", "SERVER", "TLS_CA", "TOKEN",
    // of the tests
    "CLI", "SANITIZED"};

/// Whether Kubernetes sets the variable: STIEFEL_SERVICE_HOST=10.0.0.1,
/// STIEFEL_PORT=tcp://10.0.0.1:50551, STIEFEL_PROXY_PORT_50551_TCP_ADDR=10.0.0.1.
bool of_kubernetes(const std::string& name, std::string_view value) {
  static const std::regex service("(.+_)?(SERVICE_HOST|SERVICE_PORT(_.+)?|PORT_\\d+_[A-Z]+(_.+)?)");
  static const std::regex port("(.+_)?PORT");
  return std::regex_match(name, service) ||
         (std::regex_match(name, port) && value.find("://") != value.npos);
}

}  // namespace

void check_variables(CLI::App& app) {
  for (CLI::Option* option : app.get_options([](const CLI::Option*) { return true; })) {
    const std::string& name = option->get_envname();
    const char* value = name.empty() ? nullptr : std::getenv(name.c_str());
    if (value == nullptr || *value == '\0' || option->count() > 0) continue;
    std::string text = value;
    throw CLI::ValidationError(name, (*option->get_validator())(text));
  }
}

std::vector<std::string> unknown_variables() {
  std::vector<std::string> sentences;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry, whole = text.substr(0, text.find('='));
    if (!whole.starts_with(prefix)) continue;
    const std::string name(whole.substr(prefix.size()));
    const std::string_view value = text.substr(std::min(text.size(), whole.size() + 1));
    if (std::ranges::find(known_variables, name) != known_variables.end() ||
        of_kubernetes(name, value))
      continue;
    const auto near = near_name(name, known_variables);
    sentences.push_back(std::string(whole) + ": unknown variable" +
                        (near ? "; did you mean " + std::string(prefix) + *near + "?" : ""));
  }
  std::ranges::sort(sentences);
  return sentences;
}

}  // namespace stiefel::server
