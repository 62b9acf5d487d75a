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

  /// Whether every state comes from the first one, so that between two states only its rounding
  /// changes.
  bool is_closed_form() const { return order == 0 && !own_steps; }
  bool in_float() const { return method.scalar == "float"; }
  /// Returns the method with 2^r substeps, r <= 16, or with the tolerance 10^{-3-r}, r <= 12; a
  /// closed form for r = 0 alone. Returns nullopt for larger r.
  std::optional<MethodDescription> refined(int r) const;
};

/// Returns every method of a scene's system that takes the scene, in each order, arithmetic and
/// scalar; or the violations of the first.
std::expected<std::vector<Candidate>, Violations> candidates(const Scene& start);

/// Returns the scene of a description with the recommended method, or the members of an ensemble;
/// or its violations. Ignores the method and the tolerance of the description.
std::expected<std::vector<Scene>, Violations> motions_of(SceneDescription description);

/// Describes a method: "variational of order 4, 3 substeps, plain".
std::string to_text(const MethodDescription& method);

}  // namespace stiefel
