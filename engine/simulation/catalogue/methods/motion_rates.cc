#include "engine/simulation/catalogue/methods/motion_rates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/linalg/matrix_equations/inertia_operator.h"
#include "stiefel/scene.h"

namespace stiefel {
namespace {

/// The equations dM/dt = [M, Ω], M = ΛΩ + ΩΛ, of a body in four dimensions, [RB] (2.2), (2.3), and
/// their derivative.
class Momentum {
 public:
  explicit Momentum(const Eigen::Vector4d& lambda) : lambda_(lambda) {}

  Eigen::Matrix4d field(const Eigen::Matrix4d& M) const { return bracket(M, Omega(M)); }
  /// Returns (‖M̈‖/‖M‖)^{1/2}.
  double rate(const Eigen::Matrix4d& M) const {
    const Eigen::Matrix4d dM = field(M), ddM = bracket(dM, Omega(M)) + bracket(M, Omega(dM));
    return std::sqrt(ddM.norm() / M.norm());
  }

 private:
  Eigen::Matrix4d Omega(const Eigen::Matrix4d& M) const {
    Eigen::Matrix4d Omega;
    inverse_inertia(lambda_, M, Omega);
    return Omega;
  }
  static Eigen::Matrix4d bracket(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
    return A * B - B * A;
  }
  Eigen::Vector4d lambda_;
};

constexpr int geodesic_rotations = 16, geodesic_steps = 128 * geodesic_rotations;

/// Geodesics on V(1, N) in Lagrangian form, [ST] (16): q̈ = −(q̇ᵀq̇ / qᵀΛ⁻¹q) Λ⁻¹q. Ellipsoid has
/// the same field with divisions by λ; the products with 1/λ here take less time.
template <int N>
class Geodesic {
 public:
  using Row = Eigen::Vector<double, N>;

  explicit Geodesic(const Row& lambda) : lambda_(lambda), inverse_(lambda.cwiseInverse()) {}

  /// Returns the largest (‖q⃛‖/‖q̇‖)^{1/2} in sixteen rotations; v is q̇, of norm 1.
  double largest_rate(Row q, Row v) const {
    constexpr double dt = 2 * std::numbers::pi * geodesic_rotations / geodesic_steps;
    const double E = energy(v);
    Row a = q, half_q = q, half_v = v, before = q;
    double largest = 0;  // largest ‖q⃛‖²/‖q̇‖²
    for (int k = 0; k < geodesic_steps; ++k) {
      acceleration(q, v, a);
      if (k > 0) largest = std::max(largest, (a - before).squaredNorm() / v.squaredNorm());
      before = a;
      half_q = q + dt / 2 * v;
      half_v = v + dt / 2 * a;
      acceleration(half_q, half_v, a);
      q += dt * half_v;
      v += dt * a;
      // Restores ‖q‖ = 1, q·q̇ = 0 and the energy.
      q /= q.norm();
      v -= v.dot(q) * q;
      v *= std::sqrt(E / energy(v));
    }
    return std::sqrt(std::sqrt(largest) / dt);
  }

 private:
  double energy(const Row& v) const { return v.cwiseAbs2().dot(lambda_); }
  void acceleration(const Row& q, const Row& v, Row& a) const {
    a = -v.squaredNorm() / q.cwiseAbs2().dot(inverse_) * q.cwiseProduct(inverse_);
  }

  Row lambda_, inverse_;
};

}  // namespace

double mean_momentum_rate(const Scene& scene, double angular_speed) {
  constexpr int rotations = 4, steps = 16 * rotations;
  const double size = scene.M().cwiseAbs().maxCoeff(), inertia = scene.inertia().maxCoeff();
  if (size == 0 || angular_speed == 0) return 0;
  const double dt = rotations * 2 * std::numbers::pi / steps * (size / inertia / angular_speed);
  const Momentum momentum(scene.inertia() / inertia);
  Eigen::Matrix4d M = scene.M() / size;
  double sum = 0;
  for (int k = 0; k < steps; ++k) {
    sum += std::pow(momentum.rate(M), 4);
    M += dt * momentum.field(M + dt / 2 * momentum.field(M));
  }
  return size / inertia * std::sqrt(std::sqrt(sum / steps));
}

double largest_velocity_rate(const Scene& scene) {
  const double size = scene.block("S").cwiseAbs().maxCoeff(), inertia = scene.inertia().maxCoeff();
  if (size == 0) return 0;
  const Eigen::VectorXd lambda = scene.inertia() / inertia, q = scene.Q().transpose(),
                        v = (scene.block("S") / size).transpose().cwiseQuotient(lambda);
  const double speed = v.norm(),
               rate = lambda.size() == 3
                          ? Geodesic<3>(lambda).largest_rate(q, v / speed)
                          : Geodesic<Eigen::Dynamic>(lambda).largest_rate(q, v / speed);
  return rate * speed * (size / inertia);
}

double velocity_rate_work(Eigen::Index N) {
  return geodesic_steps * (N == 3 ? 170.0 : 310 + 55 * static_cast<double>(N));
}

}  // namespace stiefel
