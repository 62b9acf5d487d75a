#pragma once

#include <expected>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel {

/// A method with its order, arithmetic and scalar: an entry of the table, but for its substeps, or
/// for its tolerance where it chooses its own steps.
struct Candidate {
  MethodDescription method;
  int order;  ///< 0 of a closed form
  bool own_steps;
  /// The declared growth of its error in the phase: linear where the energy's error stays bounded,
  /// up to quadratic where that grows too, as rounding makes it in single precision.
  bool keeps_energy;
  double weight;  ///< step_weight

  MethodDescription with_substeps(int m) const;
  MethodDescription with_tolerance(double tolerance) const;
};

/// Every method of the system that takes this scene, in each order, arithmetic and scalar; or what
/// is wrong with the scene.
std::expected<std::vector<Candidate>, Violations> candidates(const SceneDescription& description,
                                                             const Place& place = {});

/// The scene in the hands of a method; throws std::bad_expected_access for one it does not take.
Scene with_method(const SceneDescription& description, const MethodDescription& method);

/// "variational of order 4, 3 substeps, plain".
std::string to_text(const MethodDescription& method);

}  // namespace stiefel
