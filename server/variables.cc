#include "server/variables.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <regex>
#include <string_view>

#include "engine/scene/near_name.h"

namespace stiefel::server {
namespace {

constexpr std::string_view prefix = "STIEFEL_";

/// The names after the prefix. The server's are those of `stiefel-server flags`.
constexpr std::array known = {
    // of the server
    "CHECKPOINT_KEY", "GRACE", "IDLE_TIMEOUT", "INSECURE", "LISTEN", "LOG_FORMAT", "LOG_LEVEL",
    "MAX_CALL_WORK", "MAX_CONNECTIONS", "MAX_CONNECTION_AGE", "MAX_SESSIONS", "MEMORY", "METRICS",
    "PRINCIPAL_MEMORY", "PRINCIPAL_QUEUED_WORK", "PRINCIPAL_SESSIONS", "SELF_WATCH", "STORE",
    "STORE_LIMIT", "THREADS", "TLS_CERT", "TLS_CLIENT_CA", "TLS_KEY", "TOKENS",
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

std::vector<std::string> unknown_variables() {
  std::vector<std::string> sentences;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry, whole = text.substr(0, text.find('='));
    if (!whole.starts_with(prefix)) continue;
    const std::string name(whole.substr(prefix.size()));
    const std::string_view value = text.substr(std::min(text.size(), whole.size() + 1));
    if (std::ranges::find(known, name) != known.end() || of_kubernetes(name, value)) continue;
    const auto near = near_name(name, known);
    sentences.push_back(std::string(whole) + ": unknown variable" +
                        (near ? "; did you mean " + std::string(prefix) + *near + "?" : ""));
  }
  std::ranges::sort(sentences);
  return sentences;
}

}  // namespace stiefel::server
