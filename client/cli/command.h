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

// Each adds a subcommand to `all`, whose callback sets `chosen`.
void add_describe(CLI::App& all, Command& chosen);
void add_run(CLI::App& all, Command& chosen);
void add_rerun(CLI::App& all, Command& chosen);
void add_summarize(CLI::App& all, Command& chosen);
void add_poincare(CLI::App& all, Command& chosen);
void add_diagnose(CLI::App& all, Command& chosen);
void add_linearize(CLI::App& all, Command& chosen);
void add_lyapunov(CLI::App& all, Command& chosen);
void add_convert(CLI::App& all, Command& chosen);
void add_tradeoff(CLI::App& all, Command& chosen);
void add_connect(CLI::App& all, Command& chosen);
void add_conjugate_points(CLI::App& all, Command& chosen);
void add_report(CLI::App& all, Command& chosen);

/// Runs the command, and prints why it failed to stderr, one line for each fault. Returns the exit
/// status, or ends the process by the signal that interrupted it.
ExitStatus perform(Command& command);

}  // namespace stiefel::cli
