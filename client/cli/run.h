#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/endpoint.h"
#include "client/cli/exit_status.h"
#include "client/cli/origin.h"

namespace stiefel::cli {

struct RunCommand {
  std::string scene;
  Remote server;
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::optional<std::int64_t> every;
  std::string times;  ///< a file of times, instead of from, to and every
  std::vector<std::string> fields;
  std::string output;
  std::optional<bool> estimate_error;
};

/// Runs with samples at the times that a file lists instead of at steps. The diagnosis is at the
/// first step at or after the last of these times. Sets `origin.times`.
ExitStatus run_at_times(const RunCommand& command, Origin& origin);

}  // namespace stiefel::cli
