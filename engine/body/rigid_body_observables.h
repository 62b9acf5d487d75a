#pragma once

#include <optional>

#include "engine/motion/observables.h"
#include "stiefel/scene.h"

namespace stiefel {

enum class RigidBodyField {
  Q,
  M,
  Omega,
  quaternion,
  angular_velocity,
  angular_velocity_space,
  momentum_space
};

/// What a rigid-body scene offers: the kind of each field (its blocks, then Omega, and in three
/// dimensions the quaternion and the angular velocity, in space axes also the momentum), and for
/// the discrete body the map's step.
struct RigidBodyOffer {
  std::vector<RigidBodyField> kinds;
  std::optional<double> map_step;
};

/// Connects a scene with states (Q over M), or M alone, in N dimensions.
class RigidBodyObservables final : public Observables {
 public:
  explicit RigidBodyObservables(const Scene& scene);

  Point start(const Scene& scene) const override;
  void write(const Point& x, std::size_t index, std::span<double> out) const override;
  void invariants(const Point& x, InvariantList& out) const override;
  std::optional<double> orthogonality(const Point& x) const override;
  double rate(const Point& x) const override;

 private:
  RigidBodyOffer offer_;
  Eigen::VectorXd lambda_;
  int N_;
};

/// Connects a scene with a body in three dimensions, (q; m) or m alone, reported in the caller's
/// axes.
class RigidBodyObservables3 final : public Observables {
 public:
  explicit RigidBodyObservables3(const Scene& scene);

  Point start(const Scene& scene) const override;
  void write(const Point& x, std::size_t index, std::span<double> out) const override;
  void invariants(const Point& x, InvariantList& out) const override;
  std::optional<double> orthogonality(const Point& x) const override;
  double rate(const Point& x) const override;
  Point from_blocks(const Eigen::MatrixXd& blocks) const override;
  Eigen::MatrixXd to_blocks(const Point& x) const override;

 private:
  /// The vector of Q A Qᵀ in space axes for A = hat(v) in principal axes. A number that overflows
  /// is the largest one, so that a state counts as finite as long as q and v are.
  Eigen::Vector3d to_space(const Point& x, const Eigen::Vector3d& v) const;
  /// Q of a point; empty where the scene has none.
  Eigen::MatrixXd Q(const Point& x) const;
  Eigen::Vector3d omega(const Point& x) const;
  Eigen::Vector3d to_caller(const Eigen::Vector3d& v) const;

  RigidBodyOffer offer_;
  Eigen::Vector3d lambda_;
  bool frame_;
  double determinant_;
  std::optional<Eigen::Matrix3d> R_;
  Eigen::Vector4d r_conjugate_ = Eigen::Vector4d::UnitX();
};

/// Returns the observables of a scene with a rigid body: in three dimensions those of coordinates.
SharedObservables rigid_body_observables(const Scene& scene);

}  // namespace stiefel
