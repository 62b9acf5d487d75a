#pragma once

#include <optional>
#include <span>

#include "engine/dense/principal_moments_3.h"
#include "engine/numbers/quadruple.h"
#include "engine/numbers/scalar.h"
#include "stiefel/scene.h"

namespace stiefel {

/// The numbers that BodyDescription has for one body.
struct GivenBody {
  std::span<const double> tensor, moments, attitude, angular_velocity;

  /// Takes the numbers of member b of `count`; a list that does not have them for each member
  /// is common to all.
  explicit GivenBody(const BodyDescription& all, std::size_t b = 0, std::size_t count = 1);
};

/// A rigid body in three dimensions at step 0, (Q, M) along its principal axes, as numbers. An
/// ensemble has one for each member in place of a Scene.
struct Body3 {
  Eigen::Vector3d lambda;
  Eigen::Vector3d m;  ///< the vector of M
  bool has_frame = true;
  int determinant = 1;                                  ///< det Q
  Eigen::Vector4d attitude = Eigen::Vector4d::UnitX();  ///< the quaternion of det(Q) Q
  std::optional<PrincipalAxes> axes = {};               ///< of a body given by `body`
};

/// The principal axes of a body, computed in Scalar from its doubles: I = R diag(moments) Rᵀ, det R
/// = +1. Moments and a diagonal tensor keep their axes and their order, R = 1.
template <class Scalar>
struct GivenAxes {
  Vector3<Scalar> moments;
  Eigen::Matrix<Scalar, 3, 3> rotation;
};

template <class Scalar>
GivenAxes<Scalar> given_axes(const GivenBody& body);

// Compiled once, in given_body.cc.
extern template GivenAxes<double> given_axes(const GivenBody& body);
extern template GivenAxes<long double> given_axes(const GivenBody& body);
extern template GivenAxes<Quad> given_axes(const GivenBody& body);

/// Returns λ_i = ½ tr(I) − I_i, so that I_1 = λ_2 + λ_3 and cyclic.
Eigen::Vector3d inertia_of_moments(const Eigen::Vector3d& moments);

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

/// Returns a body in extended precision, from the numbers of `body` and what became of them.
ExtendedBody extended_body(const GivenBody& given, const PrincipalAxes& axes,
                           const Eigen::Vector3d& m);
/// Returns the body of a scene in extended precision; nullopt for a scene that is not given by
/// `body`.
std::optional<ExtendedBody> extended_body(const Scene& scene);

}  // namespace stiefel
