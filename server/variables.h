#pragma once

#include <string>
#include <vector>

namespace stiefel::server {

/// Returns a sentence for each variable of the environment that begins with STIEFEL_ and that
/// neither the server nor a client reads: "STIEFEL_THREAD: unknown variable; did you mean
/// STIEFEL_THREADS?". Leaves out what Kubernetes sets for a service whose name begins with stiefel.
std::vector<std::string> unknown_variables();

}  // namespace stiefel::server
