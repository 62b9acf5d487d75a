#pragma once

#include "client/cli/commands.h"

namespace stiefel::cli {

/// `run` with samples at the times of a file instead of steps; the diagnosis is at the first step
/// at or after the last of them.
ExitStatus run_at_times(const RunCommand& command);

}  // namespace stiefel::cli
