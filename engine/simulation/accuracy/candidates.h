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

/// Every method of the system that takes a scene, in each order, arithmetic and scalar.
struct Candidates {
  Scene start;  ///< the scene with the first candidate's method
  std::vector<Candidate> all;
};

/// Those of this scene, whose own method and tolerance are not looked at; or what is wrong with it.
std::expected<Candidates, Violations> candidates(SceneDescription description,
                                                 const Place& place = {});

/// The scene of a description with the recommended method, whatever its own method and tolerance;
/// or what is wrong with it.
std::expected<Scene, Violations> with_any_method(SceneDescription description,
                                                 const Place& place = {});

/// The motions of such a description: the scene, or the members of an ensemble.
std::expected<std::vector<Scene>, Violations> motions_of(SceneDescription description,
                                                         const Place& place = {});

/// "variational of order 4, 3 substeps, plain".
std::string to_text(const MethodDescription& method);

}  // namespace stiefel
