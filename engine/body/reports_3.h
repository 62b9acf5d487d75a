#pragma once

#include "engine/motion/observables.h"
#include "engine/scene/given_body.h"

namespace stiefel {

/// A body with the quaternion of axes->rotation.
struct Reported3 : Body3 {
  Reported3() = default;
  explicit Reported3(const Body3& body);

  Eigen::Vector4d axes_quaternion = Eigen::Vector4d::UnitX();
};

/// What is read of bodies in three dimensions, in the caller's axes: the fields and invariants of
/// scenes like one. A point x is (q; m) or m alone, along the principal axes.
class Reports3 {
 public:
  explicit Reports3(const Scene& like);

  const std::vector<Field>& fields() const { return fields_; }
  std::size_t block_count() const { return has_frame_ ? 2 : 1; }
  /// Returns how many numbers a point has.
  Eigen::Index size() const { return has_frame_ ? 7 : 3; }

  void write(const Reported3& body, const double* x, std::size_t index,
             std::span<double> out) const;
  void invariants(const Body3& body, const double* x, InvariantList& out) const;
  std::optional<double> orthogonality(const Body3& body, const double* x) const;
  double rate(const Body3& body, const double* x) const;

 private:
  enum class Kind {
    Q,
    M,
    Omega,
    quaternion,
    angular_velocity,
    velocity_in_space,
    momentum_in_space
  };

  void add(Kind kind, Field field);

  bool has_frame_;
  std::optional<double> map_step_;  ///< the step of the discrete body
  std::vector<Field> fields_;
  std::vector<Kind> kinds_;
};

/// Returns the body of a scene in three dimensions, also of a view.
Body3 body_3(const Scene& scene);

}  // namespace stiefel
