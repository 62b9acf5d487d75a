#pragma once

#include <optional>

#include "engine/linalg/lie/so_3.h"
#include "engine/linalg/lie/so_n.h"
#include "engine/stepping/invariant_list.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel {

enum class RigidBodyField { Q, M, Omega, quaternion, angular_velocity };

/// The fields of a rigid-body scene: its blocks, then Omega, and in three dimensions the quaternion
/// and the angular velocity.
struct RigidBodyFields {
  explicit RigidBodyFields(const Scene& scene);
  std::vector<Field> fields;
  std::vector<RigidBodyField> kinds;
  std::size_t block_count;
  std::optional<double> map_step;  ///< for the discrete body
};

/// Connects a scene with states (Q over M) in N dimensions. The member functions are compiled once
/// for each Space, in rigid_body_observables.cc.
template <class Space>
class RigidBodyObservables {
 public:
  using Point = typename Space::State;

  explicit RigidBodyObservables(const Scene& scene);

  const std::vector<Field>& fields() const { return offered_.fields; }
  std::size_t block_count() const { return offered_.block_count; }
  Point start(const Scene& scene) const;
  void invariants(const Point& x, InvariantList& out) const;
  std::optional<double> orthogonality(const Point& x) const;
  double rate(const Point& x) const;
  void write(const Point& x, std::size_t index, std::span<double> out) const;

 private:
  RigidBodyFields offered_;
  Eigen::VectorXd lambda_;
  int N_;
};

/// The observables of a body in three dimensions, reported in the caller's axes.
template <bool frame>
class RigidBodyObservables<So3<double, frame>> {
 public:
  using Space = So3<double, frame>;
  using Point = typename Space::State;

  explicit RigidBodyObservables(const Scene& scene);

  const std::vector<Field>& fields() const { return offered_.fields; }
  std::size_t block_count() const { return offered_.block_count; }
  Point start(const Scene& scene) const;
  /// Convert a state near the manifold from a matrix, Q over M, and to one.
  Point point(const Eigen::MatrixXd& stacked) const;
  Eigen::MatrixXd stacked(const Point& x) const;
  void invariants(const Point& x, InvariantList& out) const;
  std::optional<double> orthogonality(const Point& x) const;
  double rate(const Point& x) const;
  void write(const Point& x, std::size_t index, std::span<double> out) const;

 private:
  Eigen::MatrixXd Q(const Point& x) const;
  Eigen::Vector3d omega(const Point& x) const;
  Eigen::Vector3d to_caller(const Eigen::Vector3d& v) const;

  RigidBodyFields offered_;
  Eigen::VectorXd lambda_;
  double determinant_;
  std::optional<Eigen::Matrix3d> R_;
  Eigen::Vector4d r_conjugate_ = Eigen::Vector4d::UnitX();
};

extern template class RigidBodyObservables<SoN<double>>;
extern template class RigidBodyObservables<So3<double, true>>;
extern template class RigidBodyObservables<So3<double, false>>;

}  // namespace stiefel
