#include "tests/support/scenes/random_top.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace stiefel::testing {
namespace {

/// Returns the moments I₁ = λ₂ + λ₃ and cyclic.
Eigen::Vector3d moments(const Eigen::VectorXd& lambda) {
  return {lambda(1) + lambda(2), lambda(2) + lambda(0), lambda(0) + lambda(1)};
}

/// Returns the axes sorted by moment, the smallest first.
std::array<int, 3> sorted_axes(const Eigen::Vector3d& I) {
  std::array<int, 3> axes = {0, 1, 2};
  std::ranges::sort(axes, {}, [&](int a) { return I(a); });
  return axes;
}

}  // namespace

RandomTop::RandomTop(unsigned seed) : lambda(3) {
  std::mt19937_64 generator(seed);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(generator); };
  const auto signed_uniform = [&] { return 2 * uniform() - 1; };
  const auto power = [&](double least, double most) {
    return std::pow(10, least + (most - least) * uniform());
  };
  const auto either = [&](double value) { return uniform() < 0.5 ? value : -value; };

  const double spread = power(0, 2);
  for (double& l : lambda) l = std::pow(spread, uniform());
  Eigen::Vector4d q;
  for (double& c : q) c = signed_uniform();
  Eigen::Vector3d m;
  for (double& c : m) c = signed_uniform();

  const int a = static_cast<int>(3 * uniform()), b = (a + 1) % 3, c = (a + 2) % 3;
  switch (seed % 10) {
    case 0:
      kind = "generic";
      break;
    case 1:
      kind = "symmetric";
      lambda(b) = lambda(a);
      break;
    case 2:
      kind = "nearly symmetric";
      lambda(b) = lambda(a) * (1 + either(power(-15, -1)));
      break;
    case 3:
      kind = uniform() < 0.5 ? "sphere" : "plate";
      if (kind == "sphere")
        lambda.setConstant(lambda(a));
      else
        lambda(a) = 0;
      break;
    case 4:
    case 5:
      kind = "near an axis";
      m(b) = either(power(-160, -1));
      m(c) = either(power(-160, -1));
      break;
    case 6:
      kind = "near an axis in a plane";
      m(b) = either(power(-160, -1));
      m(c) = 0;
      break;
    case 7: {
      kind = "near the separatrix";
      const Eigen::Vector3d I = moments(lambda);
      const auto axes = sorted_axes(I);
      m(axes[2]) = m(axes[0]) * std::sqrt((I(axes[1]) - I(axes[0])) * I(axes[2]) /
                                          (I(axes[0]) * (I(axes[2]) - I(axes[1]))));
      m(axes[2]) *= 1 + either(power(-17, -1));
      break;
    }
    case 8:  // I = 2, 3, 6 times a power of two, in any order
      kind = "on the separatrix";
      lambda(a) = 3.5;
      lambda(b) = 2.5;
      lambda(c) = -0.5;
      lambda *= std::exp2(std::floor(8 * signed_uniform()));
      m(b) = signed_uniform();
      m(a) = std::exp2(std::floor(-4 * uniform())) * (1 + std::floor(8 * uniform()) / 8);
      m(c) = either(m(a));
      break;
    default:
      kind = "steady";
      m.setZero();
      if (uniform() < 0.8) m(a) = signed_uniform();
  }
  m *= power(-3, 3);
  x << q.normalized(), m;
  const double rate = m.cwiseQuotient(moments(lambda)).norm();
  t = either(6.283 * power(-2, 3)) / (rate > 0 ? rate : 1);
}

double RandomTop::one_and_angle() const {
  const Eigen::Vector3d I = moments(lambda), m = x.tail<3>();
  // |ω|² ≥ 2E / I₃
  return 1 + std::abs(t) * std::sqrt(m.dot(m.cwiseQuotient(I)) / I.maxCoeff());
}

bool RandomTop::near_separatrix() const {
  const Eigen::Vector3d I = moments(lambda), m = x.tail<3>();
  const auto axes = sorted_axes(I);
  const auto term = [&](int a) { return m(a) * m(a) * (I(a) - I(axes[1])) / I(a); };
  const double first = term(axes[0]), third = term(axes[2]);
  return std::abs(first + third) <= (third - first) / 16;
}

}  // namespace stiefel::testing
