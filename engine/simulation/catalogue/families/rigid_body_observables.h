#pragma once

#include <optional>

#include "engine/linalg/lie/orthogonal.h"
#include "engine/linalg/lie/so_3.h"
#include "engine/linalg/lie/so_n.h"
#include "engine/simulation/catalogue/families/discrete_hamiltonian.h"
#include "engine/simulation/catalogue/families/rigid_body_invariants.h"
#include "engine/simulation/stepping/invariant_list.h"
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

/// Connects a scene with states (Q over M) in N dimensions.
template <class Space>
class RigidBodyObservables {
 public:
  using Point = typename Space::State;

  explicit RigidBodyObservables(const Scene& scene)
      : offered_(scene), lambda_(scene.inertia()), N_(scene.dimension()) {}

  const std::vector<Field>& fields() const { return offered_.fields; }
  std::size_t block_count() const { return offered_.block_count; }

  Point start(const Scene& scene) const {
    Point x(scene.Q().rows() + N_, N_);
    if (x.rows() > N_) x.topRows(N_) = scene.Q();
    x.bottomRows(N_) = scene.M();
    return x;
  }
  void invariants(const Point& x, InvariantList& out) const {
    rigid_body_invariants(Side::left, lambda_, x.topRows(x.rows() - N_), x.bottomRows(N_), out);
    if (offered_.map_step)
      add_discrete_hamiltonian(lambda_, x.bottomRows(N_), *offered_.map_step, out);
  }
  std::optional<double> orthogonality(const Point& x) const {
    if (x.rows() == N_) return std::nullopt;
    return orthogonality_defect(x.topRows(N_));
  }
  double rate(const Point& x) const { return angular_velocity_norm(lambda_, x.bottomRows(N_)); }

  void write(const Point& x, std::size_t index, std::span<double> out) const {
    Eigen::Map<RowMatrix> block(out.data(), N_, N_);
    switch (offered_.kinds[index]) {
      case RigidBodyField::Q:
        block = x.topRows(N_);
        break;
      case RigidBodyField::M:
        block = x.bottomRows(N_);
        break;
      default: {
        typename Space::Algebra Omega(N_, N_);
        Space::inverse_inertia(lambda_, x, Omega);
        block = Omega;
      }
    }
  }

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

  explicit RigidBodyObservables(const Scene& scene)
      : offered_(scene), lambda_(scene.inertia()), determinant_(scene.determinant()) {
    if (!scene.axes()) return;
    R_ = scene.axes()->rotation;
    r_conjugate_ = quaternion_of(*R_);
    r_conjugate_.tail<3>() = -r_conjugate_.tail<3>();
  }

  const std::vector<Field>& fields() const { return offered_.fields; }
  std::size_t block_count() const { return offered_.block_count; }

  Point start(const Scene& scene) const {
    Point x;
    if constexpr (frame) x.template head<4>() = scene.attitude();
    x.template tail<3>() = vee(scene.M());
    return x;
  }
  /// Convert a state near the manifold from a matrix, Q over M, and to one.
  Point point(const Eigen::MatrixXd& stacked) const {
    Point x;
    if constexpr (frame) x.template head<4>() = quaternion_of(determinant_ * stacked.topRows(3));
    x.template tail<3>() = vee(stacked.bottomRows(3));
    return x;
  }
  Eigen::MatrixXd stacked(const Point& x) const {
    const Eigen::MatrixXd frame_part = Q(x);
    Eigen::MatrixXd out(frame_part.rows() + 3, 3);
    out << frame_part, hat(x.template tail<3>());
    return out;
  }
  void invariants(const Point& x, InvariantList& out) const {
    const Eigen::Matrix3d M = hat(x.template tail<3>());
    rigid_body_invariants(Side::left, lambda_, Q(x), M, out);
    if (offered_.map_step) add_discrete_hamiltonian(lambda_, M, *offered_.map_step, out);
  }
  std::optional<double> orthogonality(const Point& x) const {
    if constexpr (frame) return orthogonality_defect(Q(x));
    return std::nullopt;
  }
  double rate(const Point& x) const { return omega(x).norm(); }

  void write(const Point& x, std::size_t index, std::span<double> out) const {
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(out.data());
    switch (offered_.kinds[index]) {
      case RigidBodyField::Q:
        if constexpr (frame) {
          block = determinant_ * rotation_matrix<double>(x.template head<4>());
          if (R_) block *= R_->transpose();
        }
        break;
      case RigidBodyField::M:
        block = hat(to_caller(x.template tail<3>()));
        break;
      case RigidBodyField::Omega:
        block = hat(to_caller(omega(x)));
        break;
      case RigidBodyField::angular_velocity:
        Eigen::Map<Eigen::Vector3d>(out.data()) = to_caller(omega(x));
        break;
      case RigidBodyField::quaternion:
        if constexpr (frame) {
          Eigen::Map<Eigen::Vector4d> q(out.data());
          q = x.template head<4>();
          if (R_) q = Space::quaternion_times(x, r_conjugate_(0), r_conjugate_.tail<3>());
        }
        break;
    }
  }

 private:
  Eigen::MatrixXd Q(const Point& x) const {
    if constexpr (frame) return determinant_ * rotation_matrix<double>(x.template head<4>());
    return Eigen::MatrixXd(0, 0);
  }
  Eigen::Vector3d omega(const Point& x) const {
    Eigen::Vector3d w;
    Space::inverse_inertia(lambda_, x, w);
    return w;
  }
  Eigen::Vector3d to_caller(const Eigen::Vector3d& v) const { return R_ ? *R_ * v : v; }

  RigidBodyFields offered_;
  Eigen::VectorXd lambda_;
  double determinant_;
  std::optional<Eigen::Matrix3d> R_;
  Eigen::Vector4d r_conjugate_ = Eigen::Vector4d::UnitX();
};

}  // namespace stiefel
