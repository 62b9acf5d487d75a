#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "server/server.h"

namespace stiefel::server {

/// The values of the flags and environment variables of the command stiefel-server.
struct Flags {
  /// Adds the flags to `app`, whose parsing sets the values here.
  explicit Flags(CLI::App& app);
  Flags(const Flags&) = delete;
  Flags& operator=(const Flags&) = delete;

  Options options;
  bool exit_with_parent = false;
};

/// Throws CLI::ValidationError if a variable of the environment has a value that its option
/// refuses. Call it after the parse: CLI11 2.4 takes no notice of such a variable.
void check_variables(CLI::App& app);

/// Returns a sentence for each variable of the environment that begins with STIEFEL_ and that
/// neither the server nor a client reads: "STIEFEL_THREAD: unknown variable; did you mean
/// STIEFEL_THREADS?". Leaves out what Kubernetes sets for a service whose name begins with stiefel.
std::vector<std::string> unknown_variables(CLI::App& app);

/// Returns the flags of `app` as a table in Markdown: flag, variable, default, meaning.
std::string flag_table(const CLI::App& app);

}  // namespace stiefel::server
