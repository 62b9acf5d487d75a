// The solutions that errors are measured against.
#include "engine/simulation/reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/methods/variational.h"
#include "engine/problems/taylor_motion.h"
#include "engine/problems/taylor_rigid_body.h"
#include "engine/problems/taylor_stiefel.h"
#include "engine/simulation/catalogue.h"
#include "engine/simulation/simulation.h"
#include "tests/support/any_scene.h"
#include "tests/support/body_state.h"
#include "tests/support/quadruple.h"
#include "tests/support/random_frame.h"
#include "tests/support/reference_motions.h"

namespace stiefel {
namespace {

using testing::Quad;

constexpr auto never = [] { return false; };

/// Against another method in quadruple precision, whose error at 2 k steps is 2⁻⁸ of that at k.
template <class Series, class System>
void expect_agreement(Series series, const System& system, const Matrix<Quad>& start) {
  TaylorMotion<Series> motion(std::move(series), start, 1e-30);
  ASSERT_TRUE(motion.go_to(1, never));
  const auto difference = [&](int steps) {
    Variational::Map<System, Arithmetic::compensated> map(system, Quad(1) / steps, 8);
    auto state = map.start(start);
    for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
    return static_cast<double>((state.x.value - motion.state()).cwiseAbs().maxCoeff());
  };
  const double coarse = difference(40), fine = difference(80);
  EXPECT_LT(fine, 1e-15);
  EXPECT_NEAR(std::log2(coarse / fine), 8, 0.2) << coarse << " " << fine;
}

TEST(TaylorMotion, IsWhatTheVariationalMethodConvergesTo) {
  for (const int N : {3, 5}) {
    const testing::RandomBody body(N, 3);
    const Vector<Quad> lambda = body.lambda.cast<Quad>();
    expect_agreement(TaylorRigidBody<Quad>(lambda, taylor_order(1e-30)),
                     RigidBody<SoN<Quad>>(lambda), testing::state_of<SoN<Quad>>(body));
  }
  for (const auto& [n, N] : {std::pair{1, 4}, {2, 4}, {3, 5}}) {
    const testing::RandomFrame<Quad> frame(n, N, 3);
    expect_agreement(TaylorStiefel<Quad>(frame.lambda, n, taylor_order(1e-30)),
                     Stiefel<Quad>(frame.lambda, n), frame.state());
  }
}

/// Against motions in 50-digit arithmetic by extrapolation, as far as their digits go.
TEST(TaylorReference, IsTheMotionOfFiftyDigits) {
  for (const auto& motion : testing::reference_motions()) {
    SceneDescription d;
    const bool square = motion.n == motion.N;
    d.system = square ? "rigid_body" : "stiefel";
    d.method = MethodDescription{"rk4", {}, {}, "", {}};
    d.inertia = motion.lambda;
    d.step = motion.t;
    d.initial["Q"] = RowMatrix(Eigen::Map<const RowMatrix>(motion.Q_0.data(), motion.n, motion.N));
    d.initial[square ? "M" : "S"] =
        RowMatrix(Eigen::Map<const RowMatrix>(motion.momentum.data(), motion.n, motion.N));
    const Scene scene = Scene::resolve(d).value();
    const auto reference = make_reference(scene, {motion.t, 1e12});
    EXPECT_NE(reference->description().find("quadruple"), std::string::npos);
    const auto answer = reference->at(motion.t, {});
    ASSERT_TRUE(answer) << motion.name;
    EXPECT_LT(answer->error, 1e-16) << motion.name;
    const Matrix<double> Q = Eigen::Map<const RowMatrix>(motion.Q.data(), motion.n, motion.N);
    const double error = (answer->state.attitude.cast<double>() - Q).cwiseAbs().maxCoeff();
    EXPECT_LT(error, 2e-14) << motion.name;  // the initial frame is orthogonal to 1e-16 only
  }
}

/// Every system reports its motion in its own variables, and its reference does the same.
TEST(Reference, IsTheMotionOfEverySystem) {
  for (const auto& system : catalogue().systems) {
    if (system.discrete) continue;
    SceneDescription d = testing::any_scene(std::string(system.name), "adaptive", 5, 0.05);
    d.method->tolerance = 1e-13;
    const Scene scene = Scene::resolve(d).value();
    const auto reference = make_reference(scene, {8 * scene.step(), 1e12});
    const auto now = make_simulation(scene);
    for (int k = 2; k <= 8; k += 2) {
      ASSERT_TRUE(now->advance(2).reached()) << system.name;
      const auto answer = reference->at(scene.time(k), {});
      ASSERT_TRUE(answer) << system.name;
      const MotionError error = error_of(read_motion(scene, *now), answer->state);
      ASSERT_TRUE(error.attitude) << system.name;
      EXPECT_LT(error.largest(), 1e-11) << system.name << " step " << k;
      EXPECT_LT(answer->error, 1e-11) << system.name << " step " << k;
    }
  }
}

TEST(Reference, OfABodyGivenByItsMomentsIsInTheCallersAxes) {
  SceneDescription d;
  d.system = "rigid_body";
  d.method = MethodDescription{"adaptive", {}, {}, "", 1e-13};
  d.body = BodyDescription{{2, 3, 2.5, 0.3, -0.2, 0.1}, {}, {0.5, 0.5, -0.5, 0.5}, {0.3, 1, -0.7}};
  d.step = 0.5;
  const Scene scene = Scene::resolve(d).value();
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(10).reached());
  const auto answer = make_reference(scene, {5, 1e12})->at(5, {});
  ASSERT_TRUE(answer);
  EXPECT_LT(error_of(read_motion(scene, *now), answer->state).largest(), 1e-11);
}

TEST(Reference, WithoutAFrameIsOfTheMomentumAlone) {
  SceneDescription d = testing::description(testing::RandomBody(4, 2), -0.5, "adaptive");
  d.method->tolerance = 1e-13;
  d.initial.erase("Q");
  const Scene scene = Scene::resolve(d).value();
  const auto now = make_simulation(scene);
  ASSERT_TRUE(now->advance(6).reached());
  const auto answer = make_reference(scene, {3, 1e12})->at(-3, {});
  ASSERT_TRUE(answer);
  const MotionError error = error_of(read_motion(scene, *now), answer->state);
  EXPECT_FALSE(error.attitude);
  EXPECT_LT(error.momentum, 1e-11);
}

/// The estimate is not below the true error: extended precision against quadruple.
TEST(Reference, SaysHowFarItIsOff) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Scene scene = testing::random_scene(4, seed, 10, "variational");
    const auto extended = make_reference(scene, {40, 1e12, false}),
               quadruple = make_reference(scene, {40, 1e12});
    for (const double t : {10.0, 20.0, 40.0}) {
      const auto a = extended->at(t, {}), b = quadruple->at(t, {});
      ASSERT_TRUE(a && b);
      EXPECT_LE(error_of(a->state, b->state).largest(), a->error) << seed;
      EXPECT_LT(a->error, 1e-13) << seed;
      EXPECT_LT(b->error, 1e-18) << seed;
    }
  }
}

TEST(Reference, EndsWithItsBudgetOrWhenItIsToldTo) {
  const Scene scene = testing::random_scene(4, 1, 1, "variational");
  const auto poor = make_reference(scene, {1000, 1e7, false});
  EXPECT_TRUE(poor->at(1, {}));
  EXPECT_FALSE(poor->at(1000, {}));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(make_reference(scene, {1000, 1e12})->at(1000, stop.get_token()));
}

}  // namespace
}  // namespace stiefel
