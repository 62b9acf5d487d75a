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

/// The margin of an argument in the domain of a correspondence: positive inside.
struct Margin {
  /// Its name in the papers: "S_M" (the margin is 2 − ‖εM‖_op), "S_L", "E_L", ...; or "1/condition
  /// of M", of blocks from which M is a difference: they hold M ≠ 0 to 2⁻⁵³ divided by the margin.
  std::string domain;
  double margin;
};

/// A motion in other variables.
struct Conversion {
  /// The resolved scene; nothing when the target is not a system.
  std::optional<Scene> scene;
  /// The blocks of a target that is not a system.
  std::map<std::string, Eigen::MatrixXd> blocks;
  std::vector<Margin> margins;
};

/// Targets of a conversion that are not systems.
///  velocity:          Q, Qdot; J⁻¹ or 𝔐⁻¹.
///  angular_velocity:  Q, U ∈ so(N) with Q̇ = QU: 𝒵, [ST] Theorem 2; n = N: Ω = J⁻¹(M).
///  interpolation:     n = N: Q_prev, Q, Q_next, P, Sigma, Lambda_k, [RB] (7.15)–(7.21), h the
///  step.
inline constexpr const char* other_targets[] = {"velocity", "angular_velocity", "interpolation"};

struct ConversionTarget {
  std::string name;                      ///< a system, or one of `other_targets`
  std::optional<double> epsilon = {};    ///< for systems with ε; chosen when absent
  std::optional<double> parameter = {};  ///< μ of the parametric systems; the scene's when absent
  /// The places of violations: those of the converted scene, and that of `name`; "epsilon" and
  /// "parameter" have their own names.
  Place scene = Place::inside("scene");
  std::string to = "to";
};

using ConversionRefusal = std::variant<Violations, OutsideDomain>;

/// The motion of `scene` as a scene of another system, through (Q, M) where n = N and (Q, S) where
/// n < N. The step stays; the method too where it applies, else it is the recommended one, and for
/// a discrete system none. Scenes without Q, complex ones, and the discrete map of V(n, N), n < N,
/// which is not the geodesic flow, have no other form. The scene's own system gives the scene.
///
/// The members of an ensemble are converted one by one, with one method for all of them; a block
/// holds the rows of all. Margins are the smallest of any member, and a refusal names the member.
/// Where the members choose different ε, an ensemble of a symmetric system starts from Q and M,
/// with which each chooses its own; one of a parametric system takes the ε of least |ε| for all.
std::expected<Conversion, ConversionRefusal> convert(const Scene& scene,
                                                     const ConversionTarget& target);

/// The scene that starts where `now` is, a simulation of `scene`, without its solver's history. A
/// drift off the manifold is repaired up to Scene::drift_tolerance.
std::expected<Scene, Violations> scene_at(const Scene& scene, const Simulation& now,
                                          const Place& place = {});

}  // namespace stiefel
