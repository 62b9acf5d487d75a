#pragma once

#include "client/cli/commands.h"

namespace stiefel::cli {

/// Does what `run` does, with samples at the times that a file lists instead of at steps. The
/// diagnosis is at the first step at or after the last of these times. Sets `origin.times`.
ExitStatus run_at_times(const RunCommand& command, Origin& origin);

}  // namespace stiefel::cli
