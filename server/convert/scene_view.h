#pragma once

#include <string>
#include <vector>

#include "server/convert/parts.h"
#include "server/sessions/resolution.h"
#include "stiefel/v1/scene.pb.h"
#include "stiefel/v1/session.pb.h"

namespace stiefel::server {

/// An array of a description: a block, or a list of numbers as one row.
struct SceneArray {
  std::string path;  ///< "initial.Q", "inertia", "body.attitude"
  Eigen::Index rows, cols;
  const double* values;
  const double* imaginary;  ///< null where it is real

  std::size_t bytes() const {
    return static_cast<std::size_t>(rows * cols) * sizeof(double) * (imaginary ? 2 : 1);
  }
};

/// The arrays that are there, in the order of the fields.
std::vector<SceneArray> arrays_of(const SceneDescription& description);

/// An array as a field of its path.
v1::Field to_field(const SceneArray& array);

/// Writes what the view shows of a resolved description; for UNSPECIFIED what was filled in. The
/// largest arrays stay out, as many as make the rest fit into a reply: returns their paths.
std::vector<std::string> write_view(const SceneDescription& resolved, const Difference& difference,
                                    v1::SceneView view, v1::Scene* out);

}  // namespace stiefel::server
