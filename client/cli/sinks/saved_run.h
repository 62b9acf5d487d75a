#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace stiefel::cli {

/// A file that `stiefel run --output` or Trajectory.save wrote.
struct SavedRun {
  nlohmann::ordered_json description;  ///< see Description; with the outcome
  std::string samples;                 ///< the samples in one form, equal for equal bits
};

/// Reads a .npz, .csv or .json file. Throws BadInput for another file, or one without a scene.
SavedRun read_saved_run(const std::string& path);

}  // namespace stiefel::cli
