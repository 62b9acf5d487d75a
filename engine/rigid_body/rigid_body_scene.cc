#include "engine/rigid_body/rigid_body_scene.h"
#include "engine/scene/principal_axes.h"

#include <cmath>

#include "engine/linalg/lie/so_3.h"

namespace stiefel {
namespace {

std::string list_text(const std::vector<double>& list) {
  return list.empty() ? "absent" : to_text(list);
}

/// Returns the principal axes of an inertia tensor or of moments; adds violations if they are
/// invalid.
PrincipalAxes check_moments(SceneDraft& draft, const BodyDescription& body) {
  const bool tensor = !body.inertia_tensor.empty();
  if (tensor == !body.moments.empty()) {
    draft.refuse("body",
                 tensor ? "inertia_tensor and moments" : "neither inertia_tensor nor moments",
                 "needs exactly one of inertia_tensor and moments");
    return {};
  }
  const std::string field = tensor ? "body.inertia_tensor" : "body.moments";
  const auto& given = tensor ? body.inertia_tensor : body.moments;
  if (given.size() != (tensor ? 6u : 3u)) {
    draft.refuse(
        field, to_text(given),
        tensor ? "must have 6 numbers: Ixx, Iyy, Izz, Ixy, Ixz, Iyz" : "must have 3 numbers");
    return {};
  }
  if (!draft.all_finite(field, given)) return {};
  Eigen::Matrix3d I = Eigen::Vector3d(given.data()).asDiagonal();
  if (tensor) {
    I(0, 1) = I(1, 0) = given[3];
    I(0, 2) = I(2, 0) = given[4];
    I(1, 2) = I(2, 1) = given[5];
  }
  const PrincipalAxes axes = principal_axes(I);
  if (!(axes.moments.minCoeff() > 0))
    draft.refuse(field, "smallest principal moment " + to_text(axes.moments.minCoeff()),
                 "every principal moment must be > 0");
  else if (draft.check_number(field, "the smallest moment", axes.moments.minCoeff()))
    draft.check_number(field, "the largest moment", axes.moments.maxCoeff());
  return axes;
}

void check_body(SceneDraft& draft) {
  auto& body = *draft.given().body;
  if (!draft.given().inertia.empty())
    draft.refuse("inertia", to_text(draft.given().inertia), "must be absent when `body` is given");
  if (!draft.given().initial.empty())
    draft.refuse("initial", std::to_string(draft.given().initial.size()) + " blocks",
                 "must be absent when `body` is given");
  const PrincipalAxes axes = check_moments(draft, body);
  if (body.angular_velocity.size() != 3)
    draft.refuse("body.angular_velocity", list_text(body.angular_velocity), "must have 3 numbers");
  else
    draft.all_finite("body.angular_velocity", body.angular_velocity);
  if (body.attitude.empty()) body.attitude = {1, 0, 0, 0};
  if (body.attitude.size() != 4)
    draft.refuse("body.attitude", to_text(body.attitude), "must have 4 numbers: w, x, y, z");
  else if (draft.all_finite("body.attitude", body.attitude)) {
    const double norm = Eigen::Vector4d(body.attitude.data()).stableNorm();
    if (!(std::abs(norm - 1) <= draft.largest_repair()))
      draft.refuse("body.attitude", to_text(body.attitude) + " of norm " + to_text(norm),
                   "must have norm 1 to " + to_text(draft.largest_repair()));
  }
  if (!draft.sound()) return;

  const Eigen::Vector3d given_omega(body.angular_velocity.data());
  if (!draft.check_velocity("body.angular_velocity", "max |ω|", given_omega.cwiseAbs().maxCoeff()))
    return;
  const Eigen::Matrix3d& R = axes.rotation;
  const Eigen::Vector3d omega = R.transpose() * given_omega;
  Eigen::Matrix<double, 7, 1> q = Eigen::Matrix<double, 7, 1>::Zero();
  q.head<4>() = Eigen::Vector4d(body.attitude.data()).normalized();
  const Eigen::Vector3d m = axes.moments.cwiseProduct(omega);
  if (!draft.check_size("body.angular_velocity", "max |Iω|", m.cwiseAbs().maxCoeff())) return;
  const Eigen::Vector4d r = quaternion_of(R);
  draft.set_body(axes, So3<double, true>::quaternion_times(q, r(0), r.tail<3>()),
                 inertia_of_moments(axes.moments), hat(m));
}

}  // namespace

void check_no_extras(SceneDraft& draft) {
  const SceneDescription& given = draft.given();
  draft.refuse_if(given.epsilon.has_value(), "epsilon");
  draft.refuse_if(given.parameter.has_value(), "parameter");
  draft.refuse_if(!given.inertia_u.empty(), "inertia_u");
  draft.refuse_if(!given.inertia_v.empty(), "inertia_v");
}

void check_rigid_body(SceneDraft& draft, bool frame_required) {
  check_no_extras(draft);
  draft.refuse_if(draft.given().body.has_value(), "body");
  if (!draft.set_inertia()) return;
  draft.check_inertia_sums();
  draft.check_block_names();
  const Eigen::Index N = draft.scene().dimension();
  if (const RowMatrix* M = draft.block("M", N, N)) draft.set_skew("M", *M);
  if (const RowMatrix* Q = draft.block("Q", N, N, frame_required)) draft.set_frame("Q", *Q);
}

void check_rigid_body_or_engineers(SceneDraft& draft) {
  if (!draft.given().body) return check_rigid_body(draft, false);
  check_no_extras(draft);
  check_body(draft);
}

}  // namespace stiefel
