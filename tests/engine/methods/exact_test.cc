#include "engine/methods/exact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/body/exact/top_in_time.h"
#include "engine/body/rigid_body_maps.h"
#include "engine/dense/carlson.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/jacobi_elliptic.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/methods/variational.h"
#include "stiefel/simulation.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/random_top.h"
#include "tests/support/surveys/exact_survey.h"

namespace stiefel {
namespace {

using testing::Quad;

double relative(Quad value, Quad exact) {
  return static_cast<double>(abs((value - exact) / (exact == 0 ? Quad(1) : exact)));
}

/// ∫₀^∞ f(t) dt by the double exponential rule.
template <class F>
Quad integral(F f) {
  const Quad h = Quad(1) / 32, quarter_turn = 2 * atan(Quad(1));
  Quad sum = 0;
  for (int k = -208; k <= 208; ++k) {
    const Quad t = exp(quarter_turn * sinh(k * h));
    sum += h * quarter_turn * cosh(k * h) * t * f(t);
  }
  return sum;
}

TEST(Carlson, IntegralsAreTheirDefinitions) {
  std::mt19937_64 generator(1);
  const auto any = [&] {
    return std::pow(10, 4 * std::generate_canonical<double, 53>(generator) - 2);
  };
  for (int k = 0; k < 30; ++k) {
    const Quad x = k % 3 == 0 ? 0 : any(), y = any(), z = any(), p = any();
    const auto root = [&](const Quad& t) -> Quad { return sqrt((t + x) * (t + y) * (t + z)); };
    const Quad R_C = integral([&](auto& t) -> Quad { return 1 / (sqrt(t + x) * (t + y)); }) / 2;
    const Quad R_F = integral([&](auto& t) -> Quad { return 1 / root(t); }) / 2;
    const Quad R_J = integral([&](auto& t) -> Quad { return 1 / (root(t) * (t + p)); }) * 3 / 2;
    EXPECT_LT(relative(carlson::R_C(x, y), R_C), 1e-30);
    EXPECT_LT(relative(carlson::R_F(x, y, z), R_F), 1e-30);
    EXPECT_LT(relative(carlson::R_J(x, y, z, p), R_J), 1e-30);
    const auto d = [](const Quad& a) { return static_cast<double>(a); };
    EXPECT_LT(relative(carlson::R_C(d(x), d(y)), R_C), 8 * 0x1p-53);
    EXPECT_LT(relative(carlson::R_F(d(x), d(y), d(z)), R_F), 8 * 0x1p-53);
    EXPECT_LT(relative(carlson::R_J(d(x), d(y), d(z), d(p)), R_J), 16 * 0x1p-53);
  }
}

/// sn′ = cn dn, cn′ = −sn dn, by differences of order 6; their squares; F is the inverse; and K is
/// where cn ends, to the last digit even where it is tiny.
TEST(JacobiElliptic, FunctionsAreTheirDefinitions) {
  for (const double given : {1.0, 0.7, 1e-3, 1e-20, 1e-160, 1e-320}) {
    const Quad mc = given;
    const JacobiElliptic<Quad> of(mc);
    const JacobiElliptic<long double> wide(given);
    EXPECT_LT(relative(of.K(), carlson::R_F<Quad>(0, mc, 1)), 1e-32);
    for (int k = -19; k <= 19; ++k) {
      const Quad u = of.K() * k / 20, d = 1e-4;
      const auto [sn, cn, dn] = of(u);
      EXPECT_LT(relative(sn * sn + cn * cn, 1), 1e-32);
      EXPECT_LT(relative(dn * dn, mc + (1 - mc) * cn * cn), 1e-31);
      EXPECT_LT(relative(of.F(sn, cn), u), 1e-31);
      const auto slope = [&](Quad JacobiElliptic<Quad>::Values::*f) {
        const auto pair = [&](int j) -> Quad { return of(u + j * d).*f - of(u - j * d).*f; };
        return Quad((45 * pair(1) - 9 * pair(2) + pair(3)) / (60 * d));
      };
      EXPECT_LT(static_cast<double>(abs(slope(&JacobiElliptic<Quad>::Values::sn) - cn * dn)),
                1e-20);
      EXPECT_LT(static_cast<double>(abs(slope(&JacobiElliptic<Quad>::Values::cn) + sn * dn)),
                1e-20 * static_cast<double>(dn));
      const auto [s, c, e] = wide(static_cast<long double>(u));
      const double phase = 0x1p-60 * (1 + static_cast<double>(of.K()));
      EXPECT_LT(relative(Quad(s), sn), phase);
      EXPECT_LT(relative(Quad(c), cn), 20 * phase);
      EXPECT_LT(relative(Quad(e), dn), phase);
    }
  }
}

/// 10⁴ bodies of all kinds, at every distance from the separatrix.
TEST(Exact, IsTheMotionOfEveryBody) { testing::survey_exact(1, 10'000); }

using Point = TopInTime::Point;

Point rounded(const ThetaTop& top, const ThetaTop::Lanes& lanes, int lane) {
  return Point(top.state(lanes, lane).high.data());
}

/// Returns bodies with a motion in theta functions, next to the separatrix and away from it.
std::vector<ThetaTop> theta_tops(unsigned first, unsigned count) {
  std::vector<ThetaTop> tops;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const testing::RandomTop top(seed);
    if (const auto theta =
            ThetaTop::of(PrincipalMoments3<Number128>(top.lambda), top.x.cast<long double>()))
      tops.push_back(*theta);
  }
  return tops;
}

/// 300 motions from 1e-2 to 1e-12 of the separatrix, moments up to 1:10⁴, up to 10⁹ turns.
TEST(Exact, IsTheMotionNextToTheSeparatrixAfterManyTurns) {
  std::mt19937_64 generator(3);
  const auto uniform = [&] { return std::generate_canonical<double, 53>(generator); };
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d I(std::pow(10, -4 * uniform()) / 2, 0.5 + 0.4 * uniform(), 1);
    const double distance = std::pow(10, -2 - 10 * uniform());
    const double m_1 = 1 + uniform(),
                 m_3 = m_1 * std::sqrt((I(1) - I(0)) * I(2) / (I(0) * (I(2) - I(1)))) *
                       (k % 2 == 0 ? 1 + distance : 1 - distance);
    So3<Quad, true>::State x;
    x << 1, 0, 0, 0, m_1, 10 * uniform() - 5, m_3;
    const auto body = [&]<class Scalar>(Scalar) {
      const Vector3<Scalar> wide = I.cast<Scalar>();
      return PrincipalMoments3<Scalar>(
          wide, Vector3<Scalar>(wide(1) - wide(2), wide(2) - wide(0), wide(0) - wide(1)));
    };
    TopInTime top(body(Number128()), x.cast<long double>());
    ASSERT_TRUE(top.theta());
    const EulerTop<Quad> exact(body(Quad()), x);
    for (const double turns : {1., 1e3, 1e9}) {
      const double t =
          turns * uniform() * 6.283 / x.cast<double>().tail<3>().cwiseQuotient(I).norm();
      const So3<Quad, true>::State now = top.at(std::span(&t, 1)).cast<Quad>() - exact.at(t);
      EXPECT_LT(now.head<4>().norm(), 0x1p-52) << k << " " << turns;
      EXPECT_LT(now.tail<3>().norm(), x.tail<3>().norm() * 0x1p-52) << k << " " << turns;
    }
  }
}

/// A state has the same bits in every lane, beside others of its motion or beside other bodies.
TEST(Exact, HasTheSameBitsInEveryLane) {
  const auto tops = theta_tops(1, 400);
  const auto lanes = static_cast<std::size_t>(ThetaTop::lanes());
  ThetaTop::Times same{.unit = 0.3, .high = {}, .low = {}}, different = same;
  same.high.fill(12345);
  for (std::size_t lane = 0; lane < lanes; ++lane) different.high[lane] = 12345 + 7. * lane;
  ThetaTop::Lanes alone, apart, beside;
  for (std::size_t first = 0; first + lanes <= tops.size(); first += lanes) {
    ThetaTops together;
    for (std::size_t lane = 0; lane < lanes; ++lane) together.put(lane, tops[first + lane]);
    together.at(same, beside);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const ThetaTop& top = tops[first + lane];
      top.at(same, alone);
      top.at(different, apart);
      EXPECT_EQ(rounded(top, beside, lane), rounded(top, alone, 0));
      EXPECT_EQ(rounded(top, apart, 0), rounded(top, alone, lanes - 1));
    }
  }
}

#ifdef STIEFEL_X86_64
/// All instruction sets of this machine give the same bits.
TEST(Exact, HasTheSameBitsOnEveryInstructionSet) {
  const auto tops = theta_tops(1, 400);
  ThetaTop::Times times{.unit = 0.3, .high = {}, .low = {}};
  for (int lane = 0; lane < ThetaTop::most_lanes; ++lane) times.high[lane] = 1000 + 3. * lane;
  for (const ThetaTop& top : tops) {
    const auto words = [&](auto states, std::size_t lanes) {
      ThetaTop::Lanes out;
      states(top.numbers_of_motion(), times, out.words.data());
      std::vector<double> first;
      for (std::size_t i = 0; i < 2 * ThetaTop::numbers; ++i)
        for (std::size_t lane = 0; lane < 2; ++lane) first.push_back(out.words[i * lanes + lane]);
      return first;
    };
    const auto baseline = words(theta_states_of_one<Isa::baseline>, 2);
    if (widest_isa() == Isa::baseline) continue;
    EXPECT_EQ(words(theta_states_of_one<Isa::avx2>, 4), baseline);
    if (widest_isa() == Isa::avx2) continue;
    EXPECT_EQ(words(theta_states_of_one<Isa::avx512>, 8), baseline);
  }
}
#endif

TEST(Exact, AgreesWithTheReferenceSolutions) {
  using Top = EulerTop<long double>;
  int cases = 0;
  for (const auto& c : testing::reference_cases("rigid_body")) {
    const auto lambda = c.vector<long double>("inertia");
    if (lambda.size() != 3) continue;
    ++cases;
    const auto Q_0 = c.matrix<long double>("Q0"), M_0 = c.matrix<long double>("M0");
    const int sign = determinant(Q_0.cast<double>()) < 0 ? -1 : 1;
    Top::Point x;
    x << quaternion_of(sign * Q_0), vee(M_0);
    Top top(PrincipalMoments3<long double>(lambda), x);
    const Top::Point end = top.at(c.number("t"));
    const Matrix<long double> Q = sign * rotation_matrix<long double>(end.head<4>());
    // 20 digits were given; the last case turns over, and loses as many as its tilt is small.
    const long double bound = c.number("t") > 10 ? 1e-12L : 1e-17L;
    EXPECT_LT((Q - c.matrix<long double>("Q")).norm(), bound) << c.name();
    EXPECT_LT((hat(end.tail<3>()) - c.matrix<long double>("M")).norm(), 10 * bound) << c.name();
  }
  EXPECT_EQ(cases, 5);
}

/// The quaternion has no jump of sign along small steps.
TEST(Exact, TheQuaternionIsContinuous) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto simulation = make_simulation(testing::random_scene(3, seed, 0.05, "exact"));
    Eigen::MatrixXd before = simulation->get("quaternion");
    for (int k = 0; k < 1000; ++k) {
      ASSERT_TRUE(simulation->advance(1).reached());
      const Eigen::MatrixXd now = simulation->get("quaternion");
      ASSERT_LT((now - before).norm(), 0.05);
      before = now;
    }
  }
}

/// A body that starts next to its middle axis, ω = (ω₁, 1, ω₃).
struct NextToMiddleAxis {
  Eigen::Vector3d moments, omega;
  double half_period;  ///< 2K/λ, computed in 1500 digits
  double around;       ///< the axis that m circles: 1 or 3
};
const NextToMiddleAxis next_to_middle_axis[] = {
    {{1, 2, 3}, {0.1, 1, 0.1}, 11.498131472061274087, 3},
    {{1, 2, 3}, {0.4, 1, 0.1}, 8.1199830145536843462, 1},
    {{1, 2, 3}, {1e-5, 1, 1e-5}, 43.48364209572082919, 3},
    {{1, 2, 3}, {4e-5, 1, 1e-5}, 40.241585610141894401, 1},
    {{1, 2, 3}, {1e-20, 1, 1e-20}, 163.12947319421464118, 3},
    {{1, 2, 3}, {4e-20, 1, 1e-20}, 159.88741672210305724, 1},
    {{1, 2, 3}, {1e-100, 1, 1e-100}, 801.24057236483788077, 3},
    {{1, 2, 3}, {4e-100, 1, 1e-100}, 797.99851589272629682, 1},
    {{1, 2, 3}, {1e-160, 1, 1e-160}, 1279.8238967428053108, 3},
    {{1, 2, 3}, {4e-160, 1, 1e-160}, 1276.5818402706937268, 1},
    {{1, 2, 3}, {1e-200, 1, 1e-200}, 1598.8794463281169307, 3},
    {{1, 2, 3}, {4e-200, 1, 1e-200}, 1595.6373898560053468, 1},
    {{1, 2, 3}, {1e-300, 1, 1e-300}, 2396.5183202913959804, 3},
    {{1, 2, 3}, {4e-300, 1, 1e-300}, 2393.2762638192843964, 1},
    {{1, 2, 3}, {1e-310, 1, 1e-310}, 2476.282207687723896, 3},
    {{1, 1.5, 4}, {1e-5, 1, 1e-5}, 41.281650553895608593, 3},
    {{1, 1.5, 4}, {1e-200, 1, 1e-200}, 1647.6875296463878685, 3},
    {{1, 1.5, 4}, {4e-300, 1, 1e-300}, 2474.2727101801476388, 3},
};

/// After half a period ω is back with two signs changed: however small ω₁ and ω₃ are, for every
/// order of the axes. They grow like exp(λt), so an error of the period shows in them.
TEST(Exact, TurnsOverWhenItShouldHoweverNearTheMiddleAxisItStarts) {
  for (const auto& [moments, omega, half_period, around] : next_to_middle_axis)
    for (int shift = 0; shift < 3; ++shift) {
      SceneDescription d;
      d.system = "rigid_body";
      d.method = MethodDescription{"exact", {}, {}, ""};
      d.body.emplace();
      for (int k = 0; k < 3; ++k) {  // a cyclic order of the axes is a rotation of them
        d.body->moments.push_back(moments((k + shift) % 3));
        d.body->angular_velocity.push_back(omega((k + shift) % 3));
      }
      d.step = half_period;
      const auto simulation = make_simulation(Scene::resolve(d).value());
      ASSERT_TRUE(simulation->advance(1).reached());
      const Eigen::MatrixXd now = simulation->get("angular_velocity");
      for (int k = 0; k < 3; ++k) {
        const int axis = (k + shift) % 3;
        const double wanted = axis + 1 == around ? omega(axis) : -omega(axis);
        EXPECT_NEAR(now(0, k), wanted, 1e-11 * std::abs(wanted)) << omega(0) << ", axis " << axis;
      }
    }
}

}  // namespace
}  // namespace stiefel
