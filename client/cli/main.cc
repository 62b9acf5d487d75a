// The command `stiefel`: runs simulations on the server at an address, or on an embedded one.
#include <cstdlib>
#include <iostream>

#include "client/cli/command.h"
#include "server/program/command_line.h"
#include "stiefel/v1/scene.pb.h"

namespace {

/// Returns what to say of an unknown option with the name of a field of a scene; else nothing.
std::string field_hint(const std::string& explained) {
  const auto* scene = stiefel::v1::Scene::descriptor();
  for (int i = 0; i < scene->field_count(); ++i)
    if (const auto& name = scene->field(i)->name();
        explained.contains("unknown option --" + name + '\n'))
      return "A scene's field is set by --set " + name + "=VALUE\n";
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace stiefel;
  // The command explains failures itself. A user who sets GRPC_VERBOSITY gets gRPC's log as well.
  setenv("GRPC_VERBOSITY", "NONE", 0);
  CLI::App app(
      "Simulates torque-free rigid bodies in any dimension and geodesics on Stiefel manifolds, and "
      "reports how accurate the result is.",
      "stiefel");
  app.require_subcommand(1);
  app.set_version_flag("--version", STIEFEL_VERSION);
  app.footer(
      "Exit status: 0 reached, 2 bad input, 3 numerical stop (the samples before it are written),\n"
      "4 the server of --server cannot be reached, 1 any other failure. After Ctrl-C or SIGTERM\n"
      "a command prints the step it reached, removes incomplete files and ends by the signal\n"
      "(status 130, 143). After one second a command prints its progress and the time left on\n"
      "stderr; where stderr is not a terminal, it prints one line every ten seconds.");
  cli::Command command;
  cli::Subcommand::add_all(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    const std::string explained = server::explain(app, error);
    std::cerr << explained + field_hint(explained);
    return cli::bad_input;
  }
  for (const std::string& text : server::unknown_variables())
    std::cerr << "warning: " + text + '\n';
  return cli::perform(command);
}
