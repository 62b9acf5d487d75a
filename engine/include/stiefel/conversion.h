#pragma once

#include <expected>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "stiefel/outside_domain.h"
#include "stiefel/scene.h"

namespace stiefel {

class Simulation;

/// How near the edge of a correspondence's domain its argument was: positive inside.
struct Margin {
  /// Its name in the papers: "S_M" (the margin is 2 − ‖εM‖_op), "S_L", "E_L", ...; or "1/condition
  /// of M", of blocks from which M is a difference: they hold M ≠ 0 to 2⁻⁵³ divided by the margin.
  std::string domain;
  double margin;
};

/// What the same motion is in other variables.
struct Conversion {
  /// The resolved scene; nothing when the target is not a system.
  std::optional<Scene> scene;
  /// The blocks of what is not a system.
  std::map<std::string, Eigen::MatrixXd> blocks;
  std::vector<Margin> margins;
};

/// What is not a system but can be asked for.
///  velocity:          Q, Qdot; J⁻¹ or 𝔐⁻¹.
///  angular_velocity:  Q, U ∈ so(N) with Q̇ = QU: 𝒵, [ST] Theorem 2; n = N: Ω = J⁻¹(M).
///  interpolation:     n = N: Q_prev, Q, Q_next, P, Sigma, Lambda_k, [RB] (7.15)–(7.21), h the
///  step.
inline constexpr const char* other_targets[] = {"velocity", "angular_velocity", "interpolation"};

struct ConversionTarget {
  std::string name;                      ///< a system, or one of `other_targets`
  std::optional<double> epsilon = {};    ///< of the systems with a P that have one; else chosen
  std::optional<double> parameter = {};  ///< μ of the parametric systems; the scene's when absent
  /// Where violations are of: the scene that is converted, and `name`; "epsilon" and "parameter"
  /// are at their own names.
  Place scene = Place::inside("scene");
  std::string to = "to";
};

using ConversionRefusal = std::variant<Violations, OutsideDomain>;

/// The motion of `scene` as a scene of another system, through (Q, M) where n = N and (Q, S) where
/// n < N. The step stays; the method too where it applies, else it is the recommended one, and for
/// a discrete system none. Scenes without Q, complex ones, and the discrete map of V(n, N), n < N,
/// which is not the geodesic flow, have no other form. The scene's own system gives the scene.
std::expected<Conversion, ConversionRefusal> convert(const Scene& scene,
                                                     const ConversionTarget& target);

/// The scene that starts where `now` is, a simulation of `scene`, without its solver's history.
/// What the method has drifted off the manifold by is repaired up to Scene::drift_tolerance.
std::expected<Scene, Violations> scene_at(const Scene& scene, const Simulation& now,
                                          const Place& place = {});

}  // namespace stiefel
