#include "engine/methods/exact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/frames/stiefel_maps.h"
#include "engine/linalg/special_functions/carlson.h"
#include "engine/linalg/special_functions/jacobi_elliptic.h"
#include "engine/methods/variational.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "stiefel/simulation.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/surveys/exact_survey.h"

namespace stiefel {
namespace {

using testing::Quad;
using Body = RigidBody<So3<Quad, true>>;

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

/// The composition of order 8 converges to the closed form like h⁸.
TEST(Exact, IsTheLimitOfTheVariationalIntegrator) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const testing::RandomBody given(3, seed);
    const Body body(given.lambda.cast<Quad>());
    Body::State x;
    x << quaternion_of(given.Q).cast<Quad>().normalized(), vee(given.M).cast<Quad>();
    const Body::State exact = Exact::MotionOf<Body>::make(body, x).at(1);
    const auto error = [&](int steps) {
      Variational::Map<Body> map(body, Quad(1) / steps, {8, Arithmetic::plain});
      auto state = map.start(x);
      for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
      return static_cast<double>((state.x.value - exact).norm());
    };
    const double coarse = error(50), fine = error(100);
    EXPECT_LT(fine, 1e-15);
    EXPECT_NEAR(std::log2(coarse / fine), 8, 0.05);
  }
}

TEST(Exact, AgreesWithTheReferenceSolutions) {
  using WideBody = RigidBody<So3<long double, true>>;
  int cases = 0;
  for (const auto& c : testing::reference_cases("rigid_body")) {
    const auto lambda = c.vector<long double>("inertia");
    if (lambda.size() != 3) continue;
    ++cases;
    const auto Q_0 = c.matrix<long double>("Q0"), M_0 = c.matrix<long double>("M0");
    const int sign = Q_0.determinant() < 0 ? -1 : 1;
    WideBody::State x;
    x << quaternion_of(sign * Q_0), vee(M_0);
    const WideBody::State end =
        Exact::MotionOf<WideBody>::make(WideBody(lambda), x).at(c.number("t"));
    const Matrix<long double> Q = sign * rotation_matrix<long double>(end.head<4>());
    // 20 digits were given; the last case turns over, and loses as many as its tilt is small.
    const long double bound = c.number("t") > 10 ? 1e-12L : 1e-17L;
    EXPECT_LT((Q - c.matrix<long double>("Q")).norm(), bound) << c.name();
    EXPECT_LT((hat(end.tail<3>()) - c.matrix<long double>("M")).norm(), 10 * bound) << c.name();
  }
  EXPECT_EQ(cases, 5);
}

Scene scene(const std::string& method, double step, int N = 3) {
  return testing::random_scene(N, 2, step, method);
}

/// The state at step k of step h is the one at step 1 of kh; 10¹⁵ steps are no more work than one.
TEST(Exact, GoesAnywhereAtOnce) {
  constexpr std::int64_t far = 1'000'000'000'000'000;
  const auto many = make_simulation(scene("exact", 0x1p-40)),
             one = make_simulation(scene("exact", static_cast<double>(far) * 0x1p-40));
  ASSERT_TRUE(many->direct());
  ASSERT_TRUE(many->advance(far).reached());
  ASSERT_TRUE(one->advance(1).reached());
  EXPECT_EQ(many->step(), far);
  EXPECT_EQ(many->get("Q"), one->get("Q"));
  EXPECT_EQ(many->get("M"), one->get("M"));
  EXPECT_FALSE(make_simulation(scene("variational", 0.1))->direct());
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

TEST(Exact, HasNoOrder) {
  auto d = testing::description(testing::RandomBody(3, 1), 0.1, "exact");
  EXPECT_FALSE(Scene::resolve(d).value().description().method->order);
  d.method->order = 4;
  const auto refused = Scene::resolve(d);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error()[0].field, "method.order");
}

TEST(MethodsInThreeDimensions, RefuseOthers) {
  for (const char* method : {"exact", "preprocessed_variational", "splitting"}) {
    EXPECT_TRUE(Scene::resolve(testing::description(testing::RandomBody(3, 1), 0.1, method)));
    const auto refused =
        Scene::resolve(testing::description(testing::RandomBody(4, 1), 0.1, method));
    ASSERT_FALSE(refused);
    ASSERT_EQ(refused.error().size(), 1u);
    EXPECT_EQ(refused.error()[0].field, "method.name");
    EXPECT_TRUE(refused.error()[0].rule.starts_with("is only for N = 3"));
  }
}

}  // namespace
}  // namespace stiefel
