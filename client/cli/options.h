#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "client/cli/endpoint.h"
#include "client/cli/input/scene_source.h"

// Options that several commands have.
namespace stiefel::cli {

/// What errors say of --from and --to besides, because they count steps.
inline constexpr const char* between_steps =
    ": it counts steps; stiefel run --times FILE gives samples between them, and --time takes "
    "seconds";

void add_server(CLI::App* app, Remote& server);
/// Adds the scene and --set.
void add_scene(CLI::App* app, SceneSource& scene);
/// Adds the scene, --set, --to and --time.
void add_run_of_scene(CLI::App* app, SceneSource& scene);
/// Adds --error and --no-error. Without them the error is estimated when that takes less work than
/// the run or less than 10 ms.
void add_error(CLI::App* app, std::optional<bool>& estimate_error);

/// Returns a transformation of an option's text that takes every form of a whole number, such as
/// 1e3 and 30.0. It refuses other numbers with `hint`, which says what to use instead.
CLI::Validator whole_number(const std::string& hint = "");

}  // namespace stiefel::cli
