#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace stiefel::server {

/// Throws CLI::ValidationError if a variable of the environment has a value that its option
/// refuses. Call it after the parse: CLI11 2.4 takes no notice of such a variable.
void check_variables(CLI::App& app);

/// Returns a sentence for each variable of the environment that begins with STIEFEL_ and that
/// neither the server nor a client reads: "STIEFEL_THREAD: unknown variable; did you mean
/// STIEFEL_THREADS?". Leaves out what Kubernetes sets for a service whose name begins with stiefel.
std::vector<std::string> unknown_variables();

}  // namespace stiefel::server
