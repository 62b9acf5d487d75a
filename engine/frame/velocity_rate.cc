#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/frame/stiefel_forms.h"
#include "engine/motion/motion_rates.h"

namespace stiefel {
namespace {

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

}  // namespace

const MotionRates frame_rates = {.velocity = largest_velocity_rate};

}  // namespace stiefel
