#include "stiefel/conjugate_points.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <boost/math/tools/roots.hpp>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "engine/frame/geodesics/geodesic_series.h"
#include "tests/support/scenes/random_ray.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;
using testing::norm;
using testing::random_ray;

std::vector<double> times(const FoundConjugatePoints& found) {
  std::vector<double> all;
  for (const ConjugatePoint& point : found.points)
    all.insert(all.end(), static_cast<std::size_t>(point.multiplicity), point.time);
  return all;
}
void expect_times(const FoundConjugatePoints& found, const std::vector<double>& wanted,
                  double bound) {
  const auto all = times(found);
  ASSERT_EQ(all.size(), wanted.size());
  for (std::size_t k = 0; k < all.size(); ++k) EXPECT_NEAR(all[k], wanted[k], bound * wanted[k]);
}

/// Returns the sign changes of f in (0, end), a bracket every `step`.
std::vector<double> zeros(const std::function<double(double)>& f, double end, double step) {
  std::vector<double> all;
  for (double a = step / 2; a < end; a += step) {
    const double b = std::min(a + step, end);
    if (!(f(a) * f(b) < 0)) continue;
    const auto [low, high] =
        boost::math::tools::bisect(f, a, b, boost::math::tools::eps_tolerance<double>(52));
    all.push_back((low + high) / 2);
  }
  return all;
}

TEST(ConjugatePoints, OfASphereAreAtMultiplesOfPi) {
  for (const Index N : {3, 4, 5, 7})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      GeodesicRay ray = random_ray(VectorXd::Ones(N), 1, 10 * pi, seed);
      const auto found = conjugate_points(ray);
      ASSERT_TRUE(found && found->status.reached());
      ASSERT_EQ(found->points.size(), 10U);
      for (int k = 0; k < 10; ++k) {
        const ConjugatePoint& point = found->points[static_cast<std::size_t>(k)];
        EXPECT_NEAR(point.time, (k + 1) * pi, 1e-12 * point.time);
        EXPECT_EQ(point.multiplicity, N - 2);
        for (const MatrixXd& w : point.kernel) {
          EXPECT_NEAR((w * ray.Q.transpose())(0), 0, 1e-12);
          EXPECT_NEAR((w * ray.Qdot.transpose())(0), 0, 1e-9);
          EXPECT_NEAR(w.norm(), 1, 1e-12);
        }
      }
    }
}

/// A body with the moments (I_1, I_1, I_3). With m the momentum, c = m_3/|m| and η = I_1/I_3 − 1
/// the attitude is exp(x) exp(ηx_3 e_3) in unit quaternions, x = τm/|m|, τ = |m|t/2I_1, and
///
///     det dQ/dx = (sin τ / τ²) ((1 + ηc²) sin τ + η(1 − c²) τ cos τ) .
///
/// (The zeros are those of Podobryaev and Sachkov 2016.)
std::vector<double> of_a_symmetric_body(double I_1, double I_3, double m_1, double m_3,
                                        double end) {
  const double m = std::hypot(m_1, m_3), c = m_3 / m, eta = I_1 / I_3 - 1, unit = 2 * I_1 / m;
  auto all = zeros([](double tau) { return std::sin(tau); }, end / unit, 0.01);
  const auto others = zeros(
      [&](double tau) {
        return (1 + eta * c * c) * std::sin(tau) + eta * (1 - c * c) * tau * std::cos(tau);
      },
      end / unit, 0.01);
  all.insert(all.end(), others.begin(), others.end());
  std::ranges::sort(all);
  for (double& time : all) time *= unit;
  return all;
}

TEST(ConjugatePoints, OfSymmetricBodiesAreThoseOfTheClosedForm) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (const double I_3 : {1.0, 1.6, 1.99, 2.0, 0.3, 0.9, 1e-3, 1 + 1e-6})
    for (int k = 0; k < 6; ++k) {
      VectorXd moments(3), omega(3);
      moments << 1, 1, I_3;
      for (double& x : omega) x = normal(generator);
      GeodesicRay ray;
      ray.inertia = VectorXd::Constant(3, moments.sum() / 2) - moments;
      ray.Q = MatrixXd::Identity(3, 3);
      ray.Qdot.resize(3, 3);
      ray.Qdot << 0, -omega(2), omega(1), omega(2), 0, -omega(0), -omega(1), omega(0), 0;
      ray.time = 25 / norm(ray.inertia, ray.Qdot);
      const auto found = conjugate_points(ray);
      ASSERT_TRUE(found && found->status.reached());
      expect_times(
          *found,
          of_a_symmetric_body(1, I_3, std::hypot(omega(0), omega(1)), I_3 * omega(2), ray.time),
          1e-11);
      for (const ConjugatePoint& point : found->points)
        EXPECT_EQ(point.multiplicity, I_3 == 1 ? 2 : 1);
    }
}

TEST(ConjugatePoints, OfABodyThatTurnsAboutItsAxisHaveMultiplicityTwo) {
  for (const double I_3 : {1.6, 0.3}) {
    GeodesicRay ray;
    ray.inertia = (VectorXd(3) << I_3 / 2, I_3 / 2, 1 - I_3 / 2).finished();
    ray.Q = MatrixXd::Identity(3, 3);
    ray.Qdot = (MatrixXd(3, 3) << 0, -1, 0, 1, 0, 0, 0, 0, 0).finished();
    ray.time = 7 * pi / I_3;
    const auto found = conjugate_points(ray);  // τ = kπ
    ASSERT_TRUE(found);
    ASSERT_EQ(found->points.size(), 3U);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(found->points[static_cast<std::size_t>(k)].time, (k + 1) * 2 * pi / I_3, 1e-11);
      EXPECT_EQ(found->points[static_cast<std::size_t>(k)].multiplicity, 2);
    }
  }
}

/// Returns where J″ + KJ = 0, J(0) = 0, vanishes along the geodesic of an ellipsoid in R³, from its
/// Gaussian curvature K = 1/(λ_1λ_2λ_3 (Σ q_i²/λ_i)²): no code of the engine.
std::vector<double> of_an_ellipsoid(const GeodesicRay& ray) {
  using Wide = long double;
  using State = std::vector<Wide>;
  const auto field = [&](const State& x, State& dx, Wide) {
    Wide force = 0, square = 0;
    for (Index i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      force += x[k] * x[k] / ray.inertia(i);
      square += x[k + 3] * x[k + 3];
    }
    for (Index i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      dx[k] = x[k + 3];
      dx[k + 3] = -square / force * x[k] / ray.inertia(i);
    }
    dx[6] = x[7];
    dx[7] = -x[6] / (Wide(ray.inertia.prod()) * force * force);
  };
  boost::numeric::odeint::bulirsch_stoer<State, Wide> stepper(1e-17L, 1e-17L);
  State x(8, 0);
  for (Index i = 0; i < 3; ++i) {
    x[static_cast<std::size_t>(i)] = ray.Q(0, i);
    x[static_cast<std::size_t>(i + 3)] = ray.Qdot(0, i);
  }
  x[7] = 1;
  std::vector<double> all;
  const Wide step = 0.02L;
  for (Wide t = 0; t < ray.time; t += step) {
    State before = x;
    boost::numeric::odeint::integrate_adaptive(stepper, field, x, Wide(0), step, step / 4);
    if (t == 0 || before[6] * x[6] > 0) continue;
    Wide at = -before[6] / before[7];
    for (int k = 0; k < 6; ++k) {
      State y = before;
      boost::numeric::odeint::integrate_adaptive(stepper, field, y, Wide(0), at, at / 4);
      at -= y[6] / y[7];
    }
    all.push_back(static_cast<double>(t + at));
  }
  return all;
}

TEST(ConjugatePoints, OfEllipsoidsAreZerosOfTheScalarEquation) {
  const std::vector<std::array<double, 3>> ellipsoids = {{1, 1, 4},   {1, 4, 4},  {1, 1, 1.001},
                                                         {1, 1.5, 2}, {1, 3, 10}, {1, 1, 100}};
  for (const auto& axes : ellipsoids)
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const VectorXd lambda = Eigen::Map<const VectorXd>(axes.data(), 3);
      const GeodesicRay ray = random_ray(lambda, 1, 12, seed);
      const auto found = conjugate_points(ray);
      ASSERT_TRUE(found && found->status.reached());
      expect_times(*found, of_an_ellipsoid(ray), 1e-11);
    }
}

TEST(ConjugatePoints, OfTheEquatorOfAnEllipsoidOfRevolution) {
  for (const double b : {0.5, 2.0, 100.0}) {  // its Gaussian curvature there is 1/b²
    GeodesicRay ray{(VectorXd(3) << 1, 1, b * b).finished(), MatrixXd(1, 3), MatrixXd(1, 3),
                    3.5 * pi * b};
    ray.Q << 1, 0, 0;
    ray.Qdot << 0, 1, 0;
    const auto found = conjugate_points(ray);
    ASSERT_TRUE(found);
    expect_times(*found, {pi * b, 2 * pi * b, 3 * pi * b}, 1e-11);
  }
}

TEST(ConjugatePoints, HaveKernelsThatDoNotMoveTheEnd) {
  const std::vector<std::pair<Index, VectorXd>> metrics = {
      {1, VectorXd::LinSpaced(4, 1, 3)},
      {2, VectorXd::LinSpaced(4, 1, 4)},
      {2, VectorXd::Ones(5)},
      {3, VectorXd::LinSpaced(5, 1, 2)},
      {3, VectorXd::LinSpaced(4, 1, 2)},
      {4, VectorXd::LinSpaced(4, 1, 3)},
      {2, VectorXd::LinSpaced(4, 0, 4).unaryExpr([](double e) { return std::pow(10, e); })}};
  for (const auto& [n, lambda] : metrics) {
    const GeodesicRay ray = random_ray(lambda, n, 6 * std::sqrt(lambda.maxCoeff()), 3);
    const auto found = conjugate_points(ray);
    ASSERT_TRUE(found && found->status.reached());
    ASSERT_FALSE(found->points.empty()) << n;
    EXPECT_GE(found->points[0].time, injectivity_bound(lambda, n));
    for (std::size_t k = 0; k < std::min<std::size_t>(found->points.size(), 4); ++k) {
      const ConjugatePoint& point = found->points[k];
      ASSERT_EQ(point.kernel.size(), static_cast<std::size_t>(point.multiplicity));
      for (const MatrixXd& w : point.kernel) {
        constexpr double epsilon = 1e-4;
        EXPECT_NEAR(norm(lambda, w), 1, 1e-12);
        const auto end = [&](double change) {
          return geodesic_end(lambda, ray.Q, point.time * (ray.Qdot + change * w))->Q;
        };
        const MatrixXd change =
            (8 * (end(epsilon) - end(-epsilon)) - end(2 * epsilon) + end(-2 * epsilon)) /
            (12 * epsilon);
        EXPECT_LE(norm(lambda, change), 1e-8 * point.time);
      }
    }
  }
}

TEST(ConjugatePoints, OfNearlyEqualInertiasAreToldApart) {
  VectorXd lambda(4);
  for (const double apart : {1e-3, 1e-6, 1e-8}) {
    lambda << 1, 1, 1 + apart, 1 + 10 * apart;
    const auto found = conjugate_points(random_ray(lambda, 1, 6.5, 2));
    ASSERT_TRUE(found);
    ASSERT_EQ(times(*found).size(), 4U);
    ASSERT_EQ(found->points.size(), 4U);
    EXPECT_NEAR(found->points[1].time, pi, 20 * apart);
    EXPECT_GT(found->points[1].time - found->points[0].time, apart / 10);
    EXPECT_LT(found->points[0].gap, 10 * apart);
  }
  lambda << 1, 1, 1, 1 + 1e-13;
  const auto found = conjugate_points(random_ray(lambda, 1, 6.5, 2));
  ASSERT_TRUE(found);
  ASSERT_EQ(found->points.size(), 2U);
  EXPECT_EQ(found->points[0].multiplicity, 2);
}

TEST(ConjugatePoints, EndWithTheRangeOfTimes) {
  GeodesicRay ray = random_ray(VectorXd::Ones(4), 1, pi * (1 - 1e-9), 1);
  auto found = conjugate_points(ray);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->points.empty());
  EXPECT_EQ(found->until, ray.time);
  ray.time = pi;  // to rounding
  found = conjugate_points(ray);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->points.size(), 1U);
  ray.Qdot.setZero();
  found = conjugate_points(ray);
  ASSERT_TRUE(found && found->status.reached());
  EXPECT_TRUE(found->points.empty());
}

TEST(ConjugatePoints, ScaleWithTimeAndInertia) {
  const GeodesicRay ray = random_ray(VectorXd::LinSpaced(4, 1, 2), 2, 9, 4);
  const auto found = conjugate_points(ray);
  ASSERT_TRUE(found);
  ASSERT_GE(found->points.size(), 2U);
  for (const double scale : {1e-290, 1e-9, 1e9, 1e290}) {
    GeodesicRay other = ray;
    other.Qdot *= 1 / scale;
    other.time *= scale;
    other.inertia *= scale;
    const auto again = conjugate_points(other);
    ASSERT_TRUE(again && again->status.reached());
    ASSERT_EQ(again->points.size(), found->points.size());
    for (std::size_t k = 0; k < found->points.size(); ++k)
      EXPECT_NEAR(again->points[k].time / scale, found->points[k].time,
                  1e-12 * found->points[k].time);
  }
}

TEST(ConjugatePoints, StopOnRequestAndAtTheirWork) {
  GeodesicRay ray = random_ray(VectorXd::LinSpaced(4, 1, 2), 2, 1e6, 4);
  ray.most_work = 1e7;
  auto found = conjugate_points(ray);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->status.outcome, Outcome::solver_stalled);
  EXPECT_GT(found->until, 0);
  EXPECT_LT(found->until, ray.time);
  std::stop_source source;
  source.request_stop();
  ray.stop = source.get_token();
  found = conjugate_points(ray);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->status.outcome, Outcome::cancelled);
}

TEST(InjectivityBound, IsAttainedByEqualInertias) {
  for (const double scale : {0.1, 1.0, 1e4}) {
    const double unit = std::sqrt(scale) * pi;
    EXPECT_NEAR(injectivity_bound(scale * VectorXd::Ones(4), 2), unit, 1e-14 * unit);
    EXPECT_NEAR(injectivity_bound(scale * VectorXd::Ones(3), 3), std::numbers::sqrt2 * unit,
                1e-14 * unit);
  }
}

TEST(Connect, ProvesWhatTheInjectivityBoundProves) {
  const VectorXd lambda = VectorXd::LinSpaced(5, 1, 1.5);
  const Index n = 2;
  int proved = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    GeodesicRay ray = random_ray(lambda, n, 1, seed);
    const double bound = injectivity_bound(lambda, n), length = (seed % 2 ? 0.98 : 1.15) * bound;
    const TwoPointProblem problem{
        .inertia = lambda, .Q_0 = ray.Q, .Q_T = geodesic_end(lambda, ray.Q, length * ray.Qdot)->Q};
    const auto joined = connect(problem);
    ASSERT_TRUE(joined);
    const double found = std::sqrt(2 * joined->energy);
    EXPECT_EQ(joined->shortest == Shortest::yes, found <= bound);
    proved += joined->shortest == Shortest::yes;
    if (found <= bound) {
      EXPECT_NEAR(found, length, 1e-10);
    }
  }
  EXPECT_GE(proved, 5);
}

}  // namespace
}  // namespace stiefel
