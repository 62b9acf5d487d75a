#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/endpoint.h"
#include "client/cli/exit_status.h"
#include "client/cli/input/scene_source.h"
#include "client/cli/origin.h"

namespace stiefel::cli {

struct RunCommand {
  SceneSource scene;
  Remote server;
  std::int64_t from = 0;
  std::optional<std::int64_t> every;
  std::string times;  ///< a file of times, instead of from, every and the scene's end
  std::vector<std::string> fields;
  std::string output;
  std::optional<bool> estimate_error;
  std::string epoch;   ///< that of the scene; empty if it has none
  bool quiet = false;  ///< prints no report on stdout and no summary
};

/// Reads the times of `command.times`.
std::vector<double> read_times(const std::string& path);

/// Runs a scene, which is that of `command.scene`.
ExitStatus run(const RunCommand& command, const v1::Scene& scene, Origin& origin);

/// Runs with samples at these times instead of at steps. The diagnosis is at the first step at or
/// after the last of them. Sets `origin.times`.
ExitStatus run_at_times(const RunCommand& command, const v1::Scene& scene,
                        const std::vector<double>& times, Origin& origin);

}  // namespace stiefel::cli
