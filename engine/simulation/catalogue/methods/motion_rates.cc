#include "engine/simulation/catalogue/methods/motion_rates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/systems/ellipsoid.h"
#include "stiefel/scene.h"

namespace stiefel {
namespace {

/// The equations dM/dt = [M, Ω] of a body in four dimensions, M_ij = (λ_i + λ_j) Ω_ij: [RB] (2.2),
/// (2.3).
class Momentum {
 public:
  explicit Momentum(const Eigen::Vector4d& lambda)
      : sums_(lambda.replicate<1, 4>() + lambda.transpose().replicate<4, 1>()) {}

  Eigen::Matrix4d field(const Eigen::Matrix4d& M) const { return bracket(M, Omega(M)); }
  /// Returns (‖M̈‖/‖M‖)^{1/2}.
  double rate(const Eigen::Matrix4d& M) const {
    const Eigen::Matrix4d dM = field(M), ddM = bracket(dM, Omega(M)) + bracket(M, Omega(dM));
    return std::sqrt(ddM.norm() / M.norm());
  }

 private:
  Eigen::Matrix4d Omega(const Eigen::Matrix4d& M) const { return M.cwiseQuotient(sums_); }
  static Eigen::Matrix4d bracket(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
    return A * B - B * A;
  }
  Eigen::Matrix4d sums_;
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
  constexpr int rotations = 16, steps = 128 * rotations;
  constexpr double dt = 2 * std::numbers::pi * rotations / steps;
  const double size = scene.block("S").cwiseAbs().maxCoeff(), inertia = scene.inertia().maxCoeff();
  if (size == 0) return 0;
  const Eigen::VectorXd lambda = scene.inertia() / inertia;
  Matrix<double> x(2, lambda.size());
  x << scene.Q(), (scene.block("S") / size).cwiseQuotient(lambda.transpose());
  const double speed = x.row(1).norm();
  x.row(1) /= speed;
  const Ellipsoid<double> geodesic(lambda);
  const auto energy = [&] { return x.row(1).cwiseAbs2().dot(lambda); };
  const double E = energy();

  Matrix<double> half = x, dx = x, before = x;
  double largest = 0;  // largest ‖q⃛‖/‖q̇‖
  for (int k = 0; k < steps; ++k) {
    geodesic.field(x, dx);
    if (k > 0) largest = std::max(largest, (dx - before).row(1).norm() / (dt * x.row(1).norm()));
    before = dx;
    half = x + dt / 2 * dx;
    geodesic.field(half, dx);
    x += dt * dx;
    // Restores ‖q‖ = 1, q·q̇ = 0 and the energy.
    x.row(0).normalize();
    x.row(1) -= x.row(1).dot(x.row(0)) * x.row(0);
    x.row(1) *= std::sqrt(E / energy());
  }
  return std::sqrt(largest) * speed * (size / inertia);
}

}  // namespace stiefel
