#pragma once

#include <optional>

#include "engine/linalg/lie/principal_moments_3.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The body of a scene given by `body`, whose numbers are doubles, in extended precision. The
/// scene's Λ, M and principal axes are rounded to doubles, and the body that has these rounded
/// numbers turns away from the one that was given by up to about 1e-16 ‖Ω‖ t.
struct ExtendedBody {
  using Wide = long double;

  PrincipalMoments3<Wide> inertia;  ///< along its principal axes, to 2⁻⁶⁴ of the largest moment
  /// Iω − vee(Scene::M()) in the scene's axes: what M has lost.
  Vector3<Wide> momentum_tail;
  /// The principal axes as unit quaternion, w first, seen from the scene's, which are these
  /// rounded: a vector u along the former is r u r* in the latter. 1 for `moments` and for a
  /// diagonal tensor; where moments nearly coincide it may be any rotation in their plane.
  Eigen::Matrix<Wide, 4, 1> axes;
};

/// Nothing for a scene that is not given by `body`.
std::optional<ExtendedBody> extended_body(const Scene& scene);

}  // namespace stiefel
