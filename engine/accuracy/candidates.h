#pragma once

#include <expected>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel {

/// A method with its order, arithmetic and scalar: an entry of the trade-off's table without its
/// substeps, or without its tolerance where the method chooses its own steps.
struct Candidate {
  MethodDescription method;
  int order;  ///< 0 for a closed form
  bool own_steps;
  /// Whether the error in the phase grows linearly, because the error of the energy stays bounded.
  /// Otherwise the energy's error grows too, and that in the phase up to quadratically; rounding in
  /// single precision has this effect on every method.
  bool keeps_energy;
  double weight;  ///< step_weight

  MethodDescription with_substeps(int m) const;
  MethodDescription with_tolerance(double tolerance) const;
};

/// Every method of a system that takes the scene, in each order, arithmetic and scalar.
struct Candidates {
  Scene start;  ///< the scene with the method of the first candidate
  std::vector<Candidate> all;
};

/// Returns the candidates of a scene, or its violations. Ignores the method and the tolerance of
/// the description.
std::expected<Candidates, Violations> candidates(SceneDescription description,
                                                 const Place& place = {});

/// Returns the scene of a description with the recommended method, or its violations. Ignores the
/// method and the tolerance of the description.
std::expected<Scene, Violations> with_recommended_method(SceneDescription description,
                                                         const Place& place = {});

/// Returns the scene of a description with the recommended method, or the members of an ensemble.
std::expected<std::vector<Scene>, Violations> motions_of(SceneDescription description,
                                                         const Place& place = {});

/// Describes a method: "variational of order 4, 3 substeps, plain".
std::string to_text(const MethodDescription& method);

}  // namespace stiefel
