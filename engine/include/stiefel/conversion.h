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

/// How far an argument is inside the domain of a correspondence: positive inside.
struct Margin {
  /// The domain's name in the papers: "S_M" (the margin is 2 − ‖εM‖_op), "S_L", "E_L", ... Or
  /// "1/condition of M" for blocks whose difference is M: they hold M ≠ 0 with a relative error of
  /// 2⁻⁵³ / margin.
  std::string domain;
  double margin;
};

/// The result of `convert`: a motion in other variables.
struct Conversion {
  /// The resolved scene; nullopt when the target is not a system.
  std::optional<Scene> scene;
  /// The blocks of the target when it is not a system.
  std::map<std::string, Eigen::MatrixXd> blocks;
  std::vector<Margin> margins;
};

/// Targets of a conversion that are not systems.
///
///   velocity:          Q, Qdot; J⁻¹ or 𝔐⁻¹.
///   angular_velocity:  Q, U ∈ so(N) with Q̇ = QU: 𝒵, [ST] Theorem 2; n = N: Ω = J⁻¹(M).
///   interpolation:     n = N: Q_prev, Q, Q_next, P, Sigma, Lambda_k, [RB] (7.15)–(7.21), with the
///                      scene's step as h.
inline constexpr const char* other_targets[] = {"velocity", "angular_velocity", "interpolation"};

struct ConversionTarget {
  std::string name;  ///< a system, or one of `other_targets`
  /// For systems with ε, otherwise refused; `convert` chooses it when absent.
  std::optional<double> epsilon = {};
  /// μ, for the parametric systems, otherwise refused; the scene's when absent.
  std::optional<double> parameter = {};
};

/// Names the fields "to" (of the target's name, and of the resulting scene as a whole), "epsilon",
/// "parameter", and those of the scene to be converted below "scene".
using ConversionRefusal = std::variant<Violations, OutsideDomain>;

/// Converts the motion of `scene` into a scene of another system, through (Q, M) where n = N and
/// (Q, S) where n < N. The step stays. The method stays where the target accepts it; otherwise
/// the target gets its recommended method, a discrete system none. The scene's own system as target
/// returns the scene itself, unless `body` gives the scene or the target sets ε or μ. Refused are
/// ensembles, scenes without Q, complex scenes, and the discrete map of V(n, N), n < N, which is
/// not the geodesic flow.
std::expected<Conversion, ConversionRefusal> convert(const Scene& scene,
                                                     const ConversionTarget& target);

/// Returns the scene that starts from the current state of `now`, a simulation of `scene`, without
/// the history of its solver: with the numbers that `now` reports, of a body its quaternion and
/// angular velocity. At step 0 it is `scene` itself, whose numbers no state has rounded. Repairs a
/// drift off the manifold of up to Scene::drift_tolerance.
std::expected<Scene, Violations> scene_at(const Scene& scene, const Simulation& now);

}  // namespace stiefel
