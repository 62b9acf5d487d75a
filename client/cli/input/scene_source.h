#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/origin.h"
#include "stiefel/v1/scene.pb.h"

namespace stiefel::cli {

/// A scene as the command line names it, and where its run ends.
struct SceneSource {
  std::string name;                  ///< that of a file or of an example; "-" for stdin
  std::vector<std::string> changes;  ///< fields that replace those of the scene: "method.name=rk4"
  std::optional<std::int64_t> to = {};  ///< the last step
  std::optional<double> time = {};      ///< the last time, instead of `to`

  /// What errors call the scene.
  std::string shown() const { return name == "-" ? "stdin" : name; }
};

/// Reads the example of this name, stdin for "-", or a file. Throws BadInput.
std::string read_source(const std::string& name);

/// Reads a scene and changes it. It may have the forms of scene_forms.h; `origin` gets the names of
/// the blocks that stand for others. It may also have an `epoch`, the instant of its time 0, a text
/// that goes into files as it is; `epoch` gets it. Throws BadInput that names the source and the
/// fault.
v1::Scene read_scene(const SceneSource& source, Origin& origin, std::string* epoch = nullptr);

/// Returns the end of a run in steps, which is a whole number where the time is one to rounding.
/// Without `to` and `time` it is the scene's horizon. Throws BadInput where there is none, and for
/// a time before 0 or a scene without a step.
double end_in_steps(const SceneSource& source, const v1::Scene& scene);

/// Returns the last step. Throws BadInput as `end_in_steps` does, and for a time between two steps.
std::int64_t last_step(const SceneSource& source, const v1::Scene& scene);

/// Returns a time in steps; where it is a whole number to rounding, that number, as the engine
/// takes it.
double in_steps(double time, double step);

}  // namespace stiefel::cli
