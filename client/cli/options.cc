#include "client/cli/options.h"

#include <charconv>
#include <cmath>

namespace stiefel::cli {
namespace {

/// Reads the whole text as a number.
template <class Number>
bool read(const std::string& text, Number& number) {
  const std::size_t plus = text.starts_with('+') ? 1 : 0;  // from_chars takes no +
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + plus, end, number);
  return error == std::errc() && rest == end;
}

}  // namespace

CLI::Validator whole_number(const std::string& hint) {
  const auto check = [hint](std::string& text) -> std::string {
    std::int64_t whole = 0;
    double number = 0;
    if (read(text, whole)) return "";
    if (!read(text, number) || number != std::floor(number) || std::abs(number) > 0x1p53)
      return text + ": must be a whole number" + hint;
    text = std::to_string(static_cast<std::int64_t>(number));
    return "";
  };
  return CLI::Validator(check, "", "");
}

void add_server(CLI::App* app, Remote& server) {
  auto* address =
      app->add_option(
             "--server", server.address,
             "HOST:PORT or unix:PATH of a server; by default the command runs a server in its own "
             "process")
          ->type_name("ADDRESS");
  app->add_option("--tls-ca", server.tls_ca,
                  "PEM file of the authorities that signed the server's certificate; connects with "
                  "TLS")
      ->envname("STIEFEL_TLS_CA")
      ->type_name("FILE");
  app->add_option("--token-file", server.token_file,
                  "file of the token that identifies the caller; by default the token is the "
                  "variable STIEFEL_TOKEN")
      ->needs(address)
      ->type_name("FILE");
}

void add_scene(CLI::App* app, SceneSource& scene) {
  app->add_option(
         "SCENE", scene.name,
         "a scene file: the JSON form of stiefel.v1.Scene, in which matrices may be lists of "
         "rows; - for stdin; or the name of an example, such as toutatis")
      ->required()
      ->type_name("FILE.json");
  app->add_option("--set", scene.changes,
                  "a field that replaces that of the scene; null removes it. Repeatable. Example: "
                  "body.angular_velocity=0.1,1,0.2")
      ->allow_extra_args(false)
      ->type_name("FIELD=VALUE");
}

void add_run_of_scene(CLI::App* app, SceneSource& scene) {
  add_scene(app, scene);
  auto* to = app->add_option("--to", scene.to, "the last step; by default that of the horizon")
                 ->transform(whole_number(between_steps))
                 ->type_name("STEP");
  app->add_option("--time", scene.time, "the last time in seconds, instead of --to")
      ->type_name("SECONDS")
      ->excludes(to);
}

void add_error(CLI::App* app, std::optional<bool>& estimate_error) {
  auto* always = app->add_flag_callback(
      "--error", [&] { estimate_error = true; },
      "estimate the error of attitude and momentum at the last step; by default only where the "
      "estimate takes less work than the run or less than 10 ms");
  app->add_flag_callback(
         "--no-error", [&] { estimate_error = false; }, "do not estimate the error")
      ->excludes(always);
}

}  // namespace stiefel::cli
