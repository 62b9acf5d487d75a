// The tests of Principia's Euler solver on the closed form in three dimensions, with the bodies,
// states, times and tolerances of physics/euler_solver_test.cpp in
// github.com/mockingbirdnest/Principia (commit f6bc70e5, MIT License), where a tolerance of k ulps
// above 10 is met with k/10. States are taken in two words, before they are rounded; the rounded
// ones are within an ulp of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "engine/rigid_body/exact/top_in_time.h"

namespace stiefel {
namespace {

using Wide = long double;
using Vec = Vector3<Wide>;
using Rotation = Eigen::Matrix<Wide, 3, 3>;

struct Attitude {
  Vec m;
  Rotation Q;  ///< body to space
};

/// A body with principal moments, and the motion from a momentum and an attitude.
class Body {
 public:
  Body(const Eigen::Vector3d& moments, const Eigen::Vector3d& m,
       const Eigen::Matrix<Wide, 4, 1>& q = Eigen::Matrix<Wide, 4, 1>::UnitX())
      : I_(moments.cast<Wide>()),
        body_(principal(moments)),
        start_(point(q, m)),
        top_(body_, start_) {}

  Attitude at(double t) {
    TopInTime::WidePoint x = top_.theta() ? in_words(t) : alone(t);
    const auto rounded = top_.at(std::span<const double>(&t, 1));
    EXPECT_LE((rounded.cast<Wide>() - x).tail<3>().norm(), 0x1p-53L * x.tail<3>().norm());
    EXPECT_LE((rounded.cast<Wide>() - x).head<4>().norm(), 0x1p-53L);
    x.head<4>().normalize();
    return {x.tail<3>(), rotation_matrix<Wide>(x.head<4>())};
  }
  Vec omega(const Vec& m) const { return m.cwiseQuotient(I_); }

 private:
  static PrincipalMoments3<Quad> principal(const Eigen::Vector3d& I) {
    const Vector3<Quad> wide = I.cast<Quad>();
    return {wide, Vector3<Quad>(wide(1) - wide(2), wide(2) - wide(0), wide(0) - wide(1))};
  }
  static TopInTime::WidePoint point(const Eigen::Matrix<Wide, 4, 1>& q, const Eigen::Vector3d& m) {
    TopInTime::WidePoint x;
    x << q, m.cast<Wide>();
    return x;
  }
  TopInTime::WidePoint in_words(double t) {
    ThetaTop::Times times{.unit = 1, .high = {}, .low = {}};
    times.high.fill(t);
    ThetaTop::Lanes lanes;
    top_.theta()->at(times, lanes);
    const auto state = top_.theta()->state(lanes, 0);
    TopInTime::WidePoint x;
    for (int i = 0; i < ThetaTop::numbers; ++i) x(i) = Wide(state.high[i]) + Wide(state.low[i]);
    return x;
  }
  TopInTime::WidePoint alone(double t) const {
    return EulerTop<Wide, true>({body_.moments.cast<Wide>(), body_.differences.cast<Wide>()},
                                start_)
        .at(t);
  }

  Vec I_;
  PrincipalMoments3<Quad> body_;
  TopInTime::WidePoint start_;
  TopInTime top_;
};

double ulp(Wide x) {
  const double size = std::abs(static_cast<double>(x));
  return std::nextafter(size, std::numeric_limits<double>::infinity()) - size;
}
/// Asserts that two numbers, or vectors by their norms, differ by at most `ulps`, a tenth of them
/// where they are more than 10.
void expect_near(Wide x, Wide y, double ulps) {
  EXPECT_LE(std::abs(static_cast<double>(x - y)), (ulps > 10 ? ulps / 10 : ulps) * ulp(y));
}
void expect_near(const Vec& x, const Vec& y, double ulps) {
  EXPECT_LE(static_cast<double>((x - y).norm()), (ulps > 10 ? ulps / 10 : ulps) * ulp(y.norm()));
}
void expect_small(Wide x, double ulps) {
  EXPECT_LE(std::abs(static_cast<double>(x)), (ulps > 10 ? ulps / 10 : ulps) * 0x1p-52);
}

/// Draws moments in order, and components of a momentum, as Principia does.
class Random {
 public:
  Eigen::Vector3d moments() {
    std::array<double, 3> I{moment_(generator_), moment_(generator_), moment_(generator_)};
    std::ranges::sort(I);
    return {I[0], I[1], I[2]};
  }
  double component() { return momentum_(generator_); }

 private:
  std::mt19937_64 generator_{42};
  std::uniform_real_distribution<> moment_{0.0, 10.0}, momentum_{-10.0, 10.0};
};

void expect_start(const Eigen::Vector3d& moments, const Eigen::Vector3d& m, double ulps) {
  Body body(moments, m);
  expect_near(body.at(0).m, m.cast<Wide>(), ulps);
}

TEST(EulerSolver, InitialStateRandom) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d moments = random.moments();
    const double x = random.component(), y = random.component(), z = random.component();
    expect_start(moments, {x, y, z}, 209);
  }
}

TEST(EulerSolver, InitialStateSymmetrical) {
  Random random;
  for (int i = 0; i < 100; ++i) {
    const double x = random.component(), y = random.component(), z = random.component();
    expect_start({2, 2, 3}, {x, y, z}, 87);
    expect_start({2, 3, 3}, {x, y, z}, 50);
    expect_start({3, 3, 3}, {x, y, z}, 0);
  }
}

/// On both sides of the separatrix, and on it up to rounding.
TEST(EulerSolver, InitialStateOfAllFormulae) {
  Random random;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d I = random.moments();
    const auto momentum = [&](double ratio) {
      const double x = random.component(), z = x * std::sqrt(ratio);
      return Eigen::Vector3d(x, 1, i % 2 == 0 ? -z : z);
    };
    expect_start(I, momentum((I(1) - I(0)) * I(2) / ((2 * I(2) - I(1) - I(0)) * I(0))), 356);
    expect_start(I, momentum((I(1) - I(0)) * I(2) / ((I(2) - I(1)) * I(0))), 11126);
    expect_start(I, momentum((I(1) + I(2) - 2 * I(0)) * I(2) / ((I(2) - I(1)) * I(0))), 2711);
  }
}

/// Tolerances of the momentum in space, component by component, and of the energy.
struct Kept {
  std::array<double, 3> momentum;
  double energy;
};

/// Asserts that Qm and the energy stay constant on a motion with Q = I at time 0.
void expect_kept(Body& body, const Vec& m_0, const std::vector<double>& times, const Kept& kept) {
  Wide most = 0, least = std::numeric_limits<Wide>::infinity();
  for (const double t : times) {
    const auto [m, Q] = body.at(t);
    const Vec in_space = Q * m;
    for (int k = 0; k < 3; ++k)
      if (m_0(k) == 0)
        expect_small(in_space(k), kept.momentum[k]);
      else
        expect_near(in_space(k), m_0(k), kept.momentum[k]);
    const Wide energy = in_space.dot(Q * body.omega(m)) / 2;
    most = std::max(most, energy);
    least = std::min(least, energy);
  }
  expect_near(least, most, kept.energy);
}

std::vector<double> every_tenth(double end) {
  std::vector<double> times;
  for (double t = 0; t < end; t += 0.1) times.push_back(t);
  return times;
}

TEST(EulerSolver, ShortFatSymmetricTopPrecession) {
  const Vec m_0(0, 5, 7);
  Body body({3, 3, 9}, m_0.cast<double>());
  const Wide rate = m_0(2) * (3 - 9) / Wide(3 * 9);
  for (const double t : every_tenth(5))
    expect_near(body.at(t).m, Vec(5 * std::sin(rate * t), 5 * std::cos(rate * t), 7), 102);
  expect_kept(body, m_0, every_tenth(5), {{32, 4, 2}, 13});
}

TEST(EulerSolver, TallSkinnySymmetricTopPrecession) {
  const Vec m_0(7, 0, 5);
  Body body({3, 9, 9}, m_0.cast<double>());
  const Wide rate = m_0(0) * (9 - 3) / Wide(9 * 3);
  for (const double t : every_tenth(5))
    expect_near(body.at(t).m, Vec(7, 5 * std::sin(rate * t), 5 * std::cos(rate * t)), 34);
  expect_kept(body, m_0, every_tenth(5), {{3, 24, 6}, 4});
}

/// Turns over between maxima and minima of m_y, with zeros between, at equal distances.
TEST(EulerSolver, TurnsOverNextToTheMiddleAxis) {
  const Vec m_0 = Eigen::Vector3d(0, 2, 0.01).cast<Wide>();
  Body body({3, 5, 9}, m_0.cast<double>());
  std::vector<std::pair<char, double>> seen;
  double before = 2, t_before = 0;
  bool to_zero = false, rising = true;
  for (const double t : every_tenth(100)) {
    const auto m_y = static_cast<double>(body.at(t).m(1));
    const bool top = rising && m_y > 1.99 && m_y < before;
    const bool bottom = !rising && m_y < -1.99 && m_y > before;
    if (top || bottom) {
      seen.emplace_back(top ? '+' : '-', t_before);
      to_zero = true;
      rising = bottom;
    }
    if (to_zero && std::abs(m_y) < 0.1 && std::abs(m_y) > std::abs(before)) {
      seen.emplace_back('0', t_before);
      to_zero = false;
    }
    before = m_y;
    t_before = t;
  }
  ASSERT_GE(seen.size(), 4u);
  const double quarter =
      (seen.back().second - seen.front().second) / static_cast<double>(seen.size() - 1);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].first, "+0-0"[i % 4]);
    if (i == 0) continue;
    EXPECT_LT(std::abs(seen[i].second - seen[i - 1].second - quarter), 0.0023 * quarter);
  }
  expect_kept(body, m_0, every_tenth(100), {{10, 13, 965}, 33});
}

Rotation about(const Vec& axis, Wide angle) {
  return Eigen::AngleAxis<Wide>(angle, axis.normalized()).toRotationMatrix();
}

TEST(EulerSolver, SpecialCases) {
  const Eigen::Vector3d I(2, 3, 5);
  Body at_rest(I, Eigen::Vector3d::Zero());
  EXPECT_EQ(at_rest.at(10).Q, Rotation::Identity());
  EXPECT_EQ(at_rest.at(10).m, Vec::Zero());

  const std::array<double, 3> size{5, 6, 7}, ulps{1, 1, 52};
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d m = size[axis] * Eigen::Vector3d::Unit(axis);
    Body body(I, m);
    const auto [now, Q] = body.at(10);
    EXPECT_EQ(now, m.cast<Wide>());
    const Rotation expected = about(Vec::Unit(axis), Wide(10) * size[axis] / I(axis));
    for (int k = 0; k < 3; ++k) expect_near(Q.col(k), expected.col(k), ulps[axis]);
  }

  for (const double tilt :
       {std::numeric_limits<double>::epsilon(), std::numeric_limits<double>::min()}) {
    Body body(I, {tilt, 0, 1});
    const Rotation Q = body.at(10).Q, expected = about(Vec::Unit(2), Wide(10) / 5);
    for (int k = 0; k < 2; ++k)
      for (int l = 0; l < 2; ++l) expect_near(Q(l, k), expected(l, k), l == k ? 8 : 1);
    for (int k = 0; k < 2; ++k) {
      EXPECT_LE(std::abs(Q(2, k)), 2.5 * tilt);
      EXPECT_LE(std::abs(Q(k, 2)), 2.5 * tilt);
    }
    expect_near(Q(2, 2), Wide(1), 0.5);
  }

  const Rotation Q_0 =
      about(Vec::UnitY(), 0.5L) * about(Vec::UnitZ(), 1.5L) * about(Vec::UnitY(), -2.5L);
  Body sphere({3, 3, 3}, {1, 2, 4}, quaternion_of(Q_0));
  const auto [m, Q] = sphere.at(10);
  EXPECT_EQ(m, Vec(1, 2, 4));
  const Rotation expected = Q_0 * about(m, 10 * m.norm() / 3);
  const std::array<double, 3> columns{29, 68, 6};
  for (int k = 0; k < 3; ++k) expect_near(Q.col(k), expected.col(k), columns[k]);
}

/// 4179 Toutatis, with the data of Takahashi, Busch and Scheeres 2013, whose axes x, y, z are those
/// of I₂, I₃, I₁: how far observations are from the free motion, to a unit in the last digit.
struct Observation {
  int day;  ///< since 1992-11-09
  double hour;
  std::array<double, 3> angles, omega;            ///< degrees, and degrees a day
  std::array<std::array<double, 2>, 5> distance;  ///< with the unit of the last digit
};
const Observation observations[] = {
    {23, 21 + 40 / 60., 122.2, 86.5, 107.0, -35.6, 7.2, -97.0, 0.011, 1e-3, 4.5, .1, 7.9, .1, 5.4,
     .1, 5.9, .1},
    {24, 19.5, 86.3, 81.8, 24.5, -16.4, -29.1, -91.9, 0.076, 1e-3, 0.5, .1, 6.6, .1, 7.7, .1, 4.7,
     .1},
    {25, 18 + 10 / 60., 47.8, 60.7, 284.0, 29.1, -23.2, -97.8, 0.005, 1e-3, 5.0, .1, 13, 1, 15, 1,
     9.4, .1},
    {26, 18 + 50 / 60., 14.6, 39.4, 207.1, 33.3, 8.2, -92.2, 0.064, 1e-3, 1.1, .1, 9.4, .1, 4.3, .1,
     8.4, .1},
    {27, 17.5, 331.3, 23.7, 151.6, 6.6, 34.5, -95.8, 0.032, 1e-3, 0.8, .1, 2.0, .1, 0.6, .1, 2.1,
     .1},
    {28, 17 + 20 / 60., 222.5, 25.4, 143.9, 12.8, 25.4, -104.1, 0.028, 1e-3, 24, 1, 5.7, .1, 15, 1,
     15, 1},
    {29, 16 + 40 / 60., 169.8, 45.5, 106.9, -31.1, -21.9, -97.7, 0.0001, 1e-4, 2.7, .1, 3.0, .1,
     2.6, .1, 2.6, .1},
    {30, 17 + 50 / 60., 137.3, 71.3, 22.3, 11.8, -36.9, -94.9, 0.028, 1e-3, 3.4, .1, 3.4, .1, 3.4,
     .1, 1.1, .1},
    {31, 17 + 20 / 60., 103.1, 85.2, 292.6, 35.8, -8.9, -97.9, 0.0009, 1e-4, 0.8, .1, 3.1, .1, 1.4,
     .1, 3.4, .1},
    {32, 9 + 40 / 60., 77.0, 85.7, 225.5, 31.0, 17.0, -96.3, 0.022, 1e-3, 1.0, .1, 2.8, .1, 1.6, .1,
     2.7, .1},
    {33, 9 + 20 / 60., 42.8, 70.2, 133.2, -1.3, 37.0, -95.9, 0.025, 1e-3, 2.2, .1, 2.0, .1, 3.2, .1,
     2.6, .1},
    {34, 8 + 10 / 60., 13.7, 44.4, 51.9, -38.3, 17.9, -97.3, 0.013, 1e-3, 3.4, .1, 2.5, .1, 5.3, .1,
     5.3, .1},
    {35, 7 + 50 / 60., 323.7, 14.0, 0.0, -70.5, -30.6, -91.1, 0.119, 1e-3, 22, 1, 4.1, .1, 3.8, .1,
     4.5, .1},
    {36, 7 + 50 / 60., 193.2, 24.4, 21.4, 22.1, -26.6, -96.6, 0.026, 1e-3, 4.9, .1, 3.2, .1, 8.2,
     .1, 8.0, .1},
    {37, 7 + 10 / 60., 165.1, 46.4, 310.6, 33.4, -3.4, -93.7, 0.052, 1e-3, 2.6, .1, 7.3, .1, 5.8,
     .1, 8.0, .1},
    {38, 6 + 49 / 60., 130.6, 76.1, 234.9, 12.6, 33.9, -94.0, 0.045, 1e-3, 2.1, .1, 0.8, .1, 1.1,
     .1, 1.2, .1},
    {39, 7 + 9 / 60., 91.6, 81.6, 142.4, -24.3, 29.6, -102.0, 0.036, 1e-3, 2.1, .1, 5.6, .1, 6.3,
     .1, 4.1, .1},
    {5858, 10.75, 86.2, 85.0, 0.3, -0.4, -36.2, -98.9, 0.0005, 1e-4, 40, 1, 29, 1, 122, 1, 131, 1},
};

constexpr Wide degree = 3.14159265358979323846264338327950288L / 180;
Rotation by_angles(const std::array<double, 3>& a) {
  return about(Vec::UnitZ(), a[0] * degree) * about(Vec::UnitX(), a[1] * degree) *
         about(Vec::UnitZ(), a[2] * degree);
}
double angle(const Vec& a, const Vec& b) {
  return static_cast<double>(std::atan2(a.cross(b).norm(), a.dot(b)) / degree);
}

TEST(EulerSolver, Toutatis) {
  const Eigen::Vector3d I(3.0836, 3.235, 1);
  const Vec omega_0 = Vec(14.51L, 33.529L, -98.709L) * degree;
  const Vec m_0 = I.cast<Wide>().cwiseProduct(omega_0);
  Body body(I, m_0.cast<double>(), quaternion_of(by_angles({145.498, 65.865, 241.524})));
  const double noon = 17 + 49 / 60. + 47 / 3600.;
  for (const auto& [day, hour, angles, omega, distance] : observations) {
    const auto [m, Q] = body.at(day + (hour - noon) / 24);
    const Vec now = body.omega(m), seen = Vec(omega[0], omega[1], omega[2]) * degree;
    const Rotation Q_seen = by_angles(angles);
    // Principia's axes 1, 2, 3 are z, x, y here.
    const std::array<double, 5> found{static_cast<double>(std::abs(now.norm() / seen.norm() - 1)),
                                      angle(now, seen), angle(Q.col(2), Q_seen.col(2)),
                                      angle(Q.col(0), Q_seen.col(0)),
                                      angle(Q.col(1), Q_seen.col(1))};
    for (int k = 0; k < 5; ++k)
      EXPECT_NEAR(found[k], distance[k][0], distance[k][1]) << day << " " << k;
  }
}

}  // namespace
}  // namespace stiefel
