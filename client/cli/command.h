#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "client/cli/exit_status.h"
#include "client/cli/origin.h"

namespace stiefel::cli {

/// The command of a command line. It throws BadInput or client::Error where it has no outcome.
struct Command {
  std::function<ExitStatus(Origin&)> run;
  Origin origin;
};

/// A subcommand of the program: a static object in the file of each.
class Subcommand {
 public:
  /// Adds the options to `app`, whose callback sets `chosen`.
  using Add = void (*)(CLI::App* app, Command& chosen);

  Subcommand(const char* name, const char* description, Add add);
  /// Adds all subcommands, in the order of their names.
  static void add_all(CLI::App& program, Command& chosen);
};

/// Runs the command, and prints why it failed to stderr, one line for each fault. Returns the exit
/// status, or ends the process by the signal that interrupted it.
ExitStatus perform(Command& command);

}  // namespace stiefel::cli
