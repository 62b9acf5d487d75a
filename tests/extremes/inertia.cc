#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/extremes/bodies.h"
#include "tests/extremes/extremes.h"

namespace stiefel::extremes {
namespace {

const Eigen::Vector3d m(0.8, -0.5, 0.4);

void measure_body(const std::string& name, const SceneDescription& scene, std::int64_t steps = 200,
                  Limit limit = no_limit) {
  measure({"inertia", name, scene, steps, std::move(limit)});
}

/// Returns the limit of methods and scenes for which a small λ_i + λ_j makes the equations stiff.
Limit stiff(double part, int N = 3) {
  return [part, N](const SceneDescription& way) -> std::optional<std::string> {
    const std::string name = way.method ? way.method->name : "";
    if (name == "implicit_midpoint" && N > 3 && part < 1e-9)
      return "the equation of implicit_midpoint is too stiff for Newton's method by differences: "
             "LEFT_DOMAIN, and the message names a method that goes on";
    return std::nullopt;
  };
}

/// Nearly symmetric bodies, I₂ = I₁(1 + 10⁻ᵏ).
TEST(Inertia, NearSymmetric) {
  for (const int k : {2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}) {
    if (!long_form() && k % 7 != 2) continue;
    const double near = 1 + std::pow(10, -k);
    measure_body("near-symmetric, 1 + 1e-" + std::to_string(k), top({1, near, 1.5}, m, 0.1));
  }
}

TEST(Inertia, Sphere) { measure_body("sphere", top({1, 1, 1}, m, 0.1)); }

TEST(Inertia, Plate) {
  measure_body("thin plate, λ_3 = 0", top({1, 2, 3}, m, 0.1));
  for (const double negative : {-1e-15, -1e-6, -0.1, -0.3})
    measure_body("slightly negative λ_3",
                 rigid_body(Eigen::Vector3d(2, 1, negative), random_frame(3, 3, 3),
                            tumbling(Eigen::Vector3d(2, 1, 0.5), 1).initial.at("M").values, 0.1));
}

TEST(Inertia, Rod) {
  for (const double thin : {1e-3, 1e-6, 1e-9, 1e-12})
    measure_body("thin rod, I_3 = 1e" + std::to_string(std::lround(std::log10(thin))),
                 top({1, 1 + thin / 3, thin}, {0.5, -0.7, 0.8 * thin}, 0.1), 200, stiff(thin));
}

/// Inertia tensors that are hard for other engines.
TEST(Inertia, RealBodies) {
  const Eigen::Vector3d rod(1.7231e-4, 6.58e-6, 1.7243e-4), box(0.0433333, 0.0333333, 0.0166667);
  measure_body("rod of 1.7e-4 kg m², 1 ms",
               top(rod, rod.cwiseProduct(Eigen::Vector3d(3, 40, -2)), 1e-3), 1000);
  measure_body("box of 1 kg, 10 ms", top(box, box.cwiseProduct(Eigen::Vector3d(1, 2, 3)), 0.01),
               500);
}

TEST(Inertia, SpreadInertia) {
  for (const int N : {3, 8, 64})
    for (const double spread : {1e3, 1e6, 1e12}) {
      if (!long_form() && (N == 64 || spread == 1e6)) continue;
      std::ostringstream name;
      name << "λ over 1 : " << spread << ", N = " << N;
      measure_body(name.str(), tumbling(spread_inertia(N, spread), 0.1),
                   N == 3   ? 200
                   : N == 8 ? 20
                            : 5,
                   stiff(N == 3 ? 10 / spread : 1 / spread, N));
    }
}

/// λ_1 + λ_2 → 0⁺, where both are small, or of opposite signs.
TEST(Inertia, VanishingSum) {
  for (const double sum : {1e-3, 1e-8, 1e-15}) {
    if (!long_form() && sum != 1e-8) continue;
    std::ostringstream name;
    name << "λ_1 + λ_2 = " << sum;
    measure_body(name.str(), tumbling(Eigen::Vector3d(-0.5 * sum, 1.5 * sum, 1), 0.1), 200,
                 stiff(sum));
    measure_body(name.str() + ", N = 5",
                 tumbling(Eigen::VectorXd{{-0.5 * sum, 1.5 * sum, 1, 1.5, 2}}, 0.1), 20,
                 stiff(sum, 5));
  }
}

}  // namespace
}  // namespace stiefel::extremes
