#pragma once

#include <stdexcept>
#include <string>

namespace stiefel::cli {

/// The exit statuses of the command `stiefel`.
enum ExitStatus {
  reached = 0,
  failed = 1,          ///< anything else: a full disk, a server's internal error
  bad_input = 2,       ///< the command line, the scene, or what is asked of it
  numerical_stop = 3,  ///< the run ended early; what was reached is still written
  no_server = 4,       ///< the server of --server cannot be reached
};

/// Thrown for input that the user has to change. The message has one line for each fault.
struct BadInput : std::runtime_error {
  using runtime_error::runtime_error;
};

}  // namespace stiefel::cli
