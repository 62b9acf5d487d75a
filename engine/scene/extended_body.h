#pragma once

#include <optional>

#include "engine/linalg/lie/principal_moments_3.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The body of a scene given by `body`, in extended precision. The caller's numbers are doubles,
/// but the scene rounds Λ, M and the principal axes computed from them to doubles; the body with
/// these rounded numbers turns away from the given one by up to about 1e-16 ‖Ω‖ t.
struct ExtendedBody {
  using Wide = long double;

  /// Along the principal axes, with an error of 2⁻⁶⁴ of the largest moment.
  PrincipalMoments3<Wide> inertia;
  /// Iω − vee(Scene::M()) in the scene's axes: what M has lost by rounding.
  Vector3<Wide> momentum_tail;
  /// The rotation from the scene's (rounded) principal axes to the exact ones as a unit quaternion
  /// r, w first: a vector u along the exact axes is r u r* in the scene's axes. r is 1 for
  /// `moments` and for a diagonal tensor; where moments nearly coincide it may be any rotation in
  /// their plane.
  Eigen::Matrix<Wide, 4, 1> axes;
};

/// Returns the body of a scene in extended precision; nullopt for a scene that is not given by
/// `body`.
std::optional<ExtendedBody> extended_body(const Scene& scene);

}  // namespace stiefel
