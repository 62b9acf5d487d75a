#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace stiefel {

/// A field of Euler angles, or of their rates, in one sequence: "euler_angles_ZXZ",
/// "euler_rates_xyz". The three letters are SciPy's: capitals for rotations about axes of the body,
/// Q = R_a(φ₁) R_b(φ₂) R_c(φ₃) for ABC, lower case for rotations about axes of space, Q = R_c(φ₃)
/// R_b(φ₂) R_a(φ₁) for abc, where Q takes body to space.
struct EulerField {
  std::array<int, 3> axes;  ///< 0, 1 or 2; neighbours differ
  bool in_space = false;    ///< lower case
  bool rates = false;

  static constexpr std::string_view angles_of = "euler_angles_", rates_of = "euler_rates_";

  static std::optional<EulerField> named(std::string_view name);
  std::string name() const;
  /// Numbers all fields: code() < 108, and with_code(code()) is the field.
  std::size_t code() const;
  static EulerField with_code(std::size_t code);

  /// Returns the angles in radians or their rates. `q` is the attitude (w, x, y, z), body to space,
  /// of any norm, and ω the angular velocity in axes of the body.
  ///
  /// φ₁ and φ₃ are in [−π, π]; φ₂ is in [0, π] where the first and the last letter are equal, else
  /// in [−π/2, π/2]. Where φ₂ is within 1e-7 of an end of its range (gimbal lock) φ₃ = 0, and of
  /// the rates those of φ₁ and φ₃ are at least 1e7 times as large as ω; one that overflows is the
  /// largest double. From a quaternion by Bernardes and Viollet 2022.
  Eigen::Vector3d value(const Eigen::Vector4d& q, const Eigen::Vector3d& omega) const;

 private:
  Eigen::Vector3d angles(const Eigen::Vector4d& q) const;
};

}  // namespace stiefel
