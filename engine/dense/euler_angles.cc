#include "engine/dense/euler_angles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stiefel {
namespace {

/// Returns 1 where (i, j, k) is an even permutation of the axes, −1 where it is odd.
int parity(int i, int j, int k) { return (i - j) * (j - k) * (k - i) / 2; }

}  // namespace

std::optional<EulerField> EulerField::named(std::string_view name) {
  EulerField field{};
  field.rates = name.starts_with(rates_of);
  if (!field.rates && !name.starts_with(angles_of)) return std::nullopt;
  name.remove_prefix((field.rates ? rates_of : angles_of).size());
  if (name.size() != 3) return std::nullopt;
  field.in_space = name[0] >= 'a';
  for (std::size_t i = 0; i < 3; ++i) {
    field.axes[i] = name[i] - (field.in_space ? 'x' : 'X');
    const bool axis = field.axes[i] >= 0 && field.axes[i] < 3;
    if (!axis || (i > 0 && field.axes[i] == field.axes[i - 1])) return std::nullopt;
  }
  return field;
}

std::string EulerField::name() const {
  std::string out(rates ? rates_of : angles_of);
  for (const int axis : axes) out += static_cast<char>((in_space ? 'x' : 'X') + axis);
  return out;
}

std::size_t EulerField::code() const {
  const int sequence = (axes[0] * 3 + axes[1]) * 3 + axes[2];
  return static_cast<std::size_t>(sequence * 4 + in_space * 2 + rates);
}

EulerField EulerField::with_code(std::size_t code) {
  const auto sequence = static_cast<int>(code / 4);
  return {{sequence / 9, sequence / 3 % 3, sequence % 3}, code / 2 % 2 == 1, code % 2 == 1};
}

Eigen::Vector3d EulerField::angles(const Eigen::Vector4d& q) const {
  constexpr double lock = 1e-7, pi = std::numbers::pi;
  const int first = in_space ? 0 : 2, third = 2 - first;
  const auto axis = [&](int n) { return axes[static_cast<std::size_t>(n)]; };
  const int i = axis(first), j = axis(1), k = 3 - i - j;
  const bool proper = axis(third) == i;
  const double sign = parity(i, j, k), w = q(0), x = q(1 + i), y = q(1 + j), z = sign * q(1 + k);
  const double a = proper ? w : w - y, b = proper ? x : x + z;
  const double c = proper ? y : w + y, d = proper ? z : z - x;
  const double half_sum = std::atan2(b, a), half_difference = std::atan2(d, c);
  Eigen::Vector3d out;
  out(1) = 2 * std::atan2(std::hypot(c, d), std::hypot(a, b));
  const bool low = out(1) <= lock, high = out(1) >= pi - lock;
  out(first) = half_sum - half_difference;
  out(third) = half_sum + half_difference;
  if (low || high) {
    out(0) = low ? 2 * half_sum : (in_space ? -2 : 2) * half_difference;
    out(2) = 0;
  }
  if (!proper) {
    out(third) *= sign;
    out(1) -= pi / 2;
  }
  for (const int n : {0, 2}) out(n) = std::remainder(out(n), 2 * pi);
  return out;
}

Eigen::Vector3d EulerField::value(const Eigen::Vector4d& q, const Eigen::Vector3d& omega) const {
  Eigen::Vector3d phi = angles(q);
  if (!rates) return phi;
  // A sequence in space is the reverse one in the body. With a, b, c the axes in the body and
  // e_a × e_b = σ e_f, R_c(φ₃) ω = φ₃' e_c + φ₂' e_b + φ₁' (cos φ₂ e_a + σ sin φ₂ e_f).
  if (in_space) phi.reverseInPlace();
  const int a = axes[in_space ? 2 : 0], b = axes[1], c = axes[in_space ? 0 : 2], f = 3 - a - b;
  const double sigma = parity(a, b, f), cosine = std::cos(phi(1)), sine = sigma * std::sin(phi(1));
  const Eigen::Vector3d u = Eigen::AngleAxisd(phi(2), Eigen::Vector3d::Unit(c)) * omega;
  const double first = c == a ? u(f) / sine : u(a) / cosine;
  Eigen::Vector3d out(first, u(b), c == a ? u(a) - cosine * first : u(f) - sine * first);
  if (in_space) out.reverseInPlace();
  constexpr double most = std::numeric_limits<double>::max();
  return out.unaryExpr([](double x) { return x < most ? std::max(x, -most) : most; });
}

}  // namespace stiefel
