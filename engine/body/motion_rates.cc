#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/body/exact/sorted_top.h"
#include "engine/body/rigid_body_data.h"
#include "engine/dense/principal_moments_3.h"
#include "engine/dense/so_3.h"
#include "engine/motion/body_view.h"
#include "stiefel/scene.h"

namespace stiefel {
namespace {

/// Returns a body in three dimensions. Moments and momentum are divided by their largest element,
/// so that no square overflows.
SortedTop<double> sorted_top(const Eigen::Vector3d& lambda, const Eigen::Vector3d& m) {
  const auto [I, differences] = PrincipalMoments3<double>(lambda);
  return {{I / I.maxCoeff(), differences / I.maxCoeff()}, m / m.cwiseAbs().maxCoeff()};
}

double separatrix_parameter(const Eigen::Vector3d& lambda, const Eigen::Vector3d& m) {
  return m.isZero(0) ? 1 : sorted_top(lambda, m).complementary_parameter();
}

double largest_turning_rate(const Scene& scene) {
  const Eigen::Vector3d momentum = vee(body_momentum(scene));
  if (momentum.isZero(0)) return 0;
  const auto top = sorted_top(scene.inertia(), momentum);
  const int i = top.circled(), k = 2 - i;
  const auto& [I, m, Delta] = std::tie(top.I, top.m, top.Delta);
  const auto quotient = [](double a, double b) { return b != 0 ? a / b : 0; };
  // The squares of m where m_j = 0, and where |m_j| is largest.
  const double B_i = quotient(I(i) * Delta(k), top.difference(i, k)),
               B_k = quotient(I(k) * Delta(i), top.difference(k, i)),
               B_j = std::min(quotient(I(1) * Delta(i), top.difference(1, i)), top.G * top.G);
  const auto square = [&](double m_i, double m_j, double m_k) {
    return m_i / (I(i) * I(i)) + m_j / (I(1) * I(1)) + m_k / (I(k) * I(k));
  };
  const double now = m.cwiseQuotient(I).squaredNorm();
  const double omega = std::max({now, square(B_i, 0, B_k), square(top.G * top.G - B_j, B_j, 0)});
  const double lambda = std::abs(Delta(k) * top.difference(i, 1)) / (I(0) * I(1) * I(2));
  const double unit = momentum.cwiseAbs().maxCoeff() /
                      PrincipalMoments3<double>(scene.inertia()).moments.maxCoeff();
  return unit * std::sqrt(std::max(omega, lambda));
}

}  // namespace

const MotionRates body_rates = {.turning = largest_turning_rate,
                                .separatrix = separatrix_parameter};

}  // namespace stiefel
