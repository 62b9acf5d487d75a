#include "server/program/command_line.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <regex>
#include <string_view>
#include <vector>

#include "engine/scene/near_name.h"

namespace stiefel::server {
namespace {

using Names = std::vector<std::string>;

Names commands(const CLI::App& app) {
  Names names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

Names options(const CLI::App& app) {
  Names names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  }
  return names;
}

std::string listed(const Names& names) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

std::string unknown_command(const std::string& word, const Names& known) {
  const std::string fault = "unknown command " + word;
  if (const auto near = near_name(word, known)) return fault + "; did you mean " + *near + "?";
  return fault + "; the commands are " + listed(known);
}

std::string unknown_option(const std::string& word, const Names& known) {
  const std::string name = word.substr(0, word.find('='));
  const auto near = near_name(name.substr(name.find_first_not_of('-')), known);
  const std::string fault = "unknown option " + name;
  return near ? fault + "; did you mean --" + *near + "?" : fault;
}

bool is_option(const std::string& word) {
  return word.starts_with("-") && word.find_first_not_of('-') != std::string::npos;
}

/// The options that a command takes, its own and, if it falls through, those of the program.
Names options_of(const CLI::App& app, const CLI::App& command) {
  Names names = options(command);
  if (&command != &app && command.get_fallthrough())
    std::ranges::copy(options(app), std::back_inserter(names));
  return names;
}

Names faults(const CLI::App& app, const CLI::App& command, const CLI::ParseError& error) {
  const Names words = app.remaining(true);
  if (&command == &app && !words.empty() && !is_option(words.front()))
    return {unknown_command(words.front(), commands(app))};
  Names out;
  for (const std::string& word : words) {
    if (is_option(word)) out.push_back(unknown_option(word, options_of(app, command)));
  }
  if (out.empty() && dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) {
    for (const std::string& word : words) out.push_back("unexpected argument " + word);
  }
  if (out.empty() && dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && &command == &app)
    out.push_back(std::string("a command is required: ") + listed(commands(app)));
  if (out.empty()) out.push_back(error.what());
  return out;
}

constexpr std::string_view prefix = "STIEFEL_";

/// The names after the prefix. The server's are those of `stiefel-server flags`.
constexpr std::array known_variables = {
    // of the server
    "GRACE", "IDLE_TIMEOUT", "INSECURE", "LISTEN", "LOG_FORMAT", "LOG_LEVEL", "MAX_CALL_WORK",
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

std::string explain(const CLI::App& app, const CLI::ParseError& error) {
  const auto parsed = app.get_subcommands();
  const CLI::App& command = parsed.empty() ? app : *parsed.front();
  std::string text;
  for (const std::string& fault : faults(app, command, error))
    text += app.get_name() + ": error: " + fault + '\n';
  return text + "See " + app.get_name() + " " + (parsed.empty() ? "" : command.get_name() + " ") +
         "--help\n";
}

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
