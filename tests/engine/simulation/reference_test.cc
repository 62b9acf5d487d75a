// The reference solutions against which errors are measured.
#include "engine/accuracy/reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/body/rigid_body_maps.h"
#include "engine/bracket/taylor_double_bracket.h"
#include "engine/dense/taylor_motion.h"
#include "engine/dense/taylor_rigid_body.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/frame/taylor_stiefel.h"
#include "engine/methods/variational.h"
#include "engine/motion/system_entry.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "tests/support/extrapolation.h"
#include "tests/support/linalg/quadruple.h"
#include "tests/support/motion_in_quadruple.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/body_state.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_matrices.h"

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
    auto map = map_of(Variational(), system, Quad(1) / steps, 8);
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

/// Every element at several times, forwards and back, against the printed equations by
/// extrapolation.
template <class Series, class Field>
void expect_the_flow(const Series& series, const Field& field, const Matrix<Quad>& start,
                     const auto& in_the_series) {
  for (const double sign : {1.0, -1.0}) {
    TaylorMotion<Series> motion(series, in_the_series(start), 1e-30);
    Matrix<Quad> x = start;
    for (int k = 1; k <= 3; ++k) {
      x = testing::extrapolate(field, x, Quad(sign), 16);
      ASSERT_TRUE(motion.go_to(sign * k, never));
      const Matrix<Quad> exact = in_the_series(x);
      const double size = static_cast<double>(exact.cwiseAbs().maxCoeff());
      EXPECT_LT(static_cast<double>((motion.state() - exact).cwiseAbs().maxCoeff()), 1e-22 * size);
    }
  }
}

TEST(TaylorMotion, OfTheDoubleBracketIsThePrintedOne) {
  for (const auto& [p, q] : {std::pair{1, 1}, {1, 3}, {3, 2}}) {
    testing::RandomMatrices<Quad> random(static_cast<unsigned>(10 * p + q));
    const Vector<Quad> u = random.lambda(p), v = random.lambda(q);
    expect_the_flow(TaylorDoubleBracket<Quad>(u, v, taylor_order(1e-30)),
                    testing::PrintedDoubleBracket(u, v), random.matrix(4 * p, q) / 3,
                    [](const Matrix<Quad>& x) { return x; });
  }
}

TEST(TaylorMotion, OfTheParametricRigidBodyIsThePrintedOne) {
  for (const int N : {2, 5})
    for (const double mu : {0.0, -0.2}) {
      testing::RandomMatrices<Quad> random(static_cast<unsigned>(N));
      const Vector<Quad> lambda = random.lambda(N);
      const testing::PrintedParametricRigidBody printed(lambda, mu);
      // Off the manifold on which M is skew, too.
      Matrix<Quad> start(2 * N, N);
      start << random.frame(N, N), random.frame(N, N) + random.matrix(N, N) / 20;
      expect_the_flow(TaylorRigidBody<Quad, true>(lambda, mu, taylor_order(1e-30)), printed, start,
                      [&](const Matrix<Quad>& x) {
                        Matrix<Quad> made(2 * N, N);
                        made << x.topRows(N), printed.M(x);
                        made.bottomRows(N).diagonal() += Quad(mu) * lambda.cwiseAbs2();
                        return made;
                      });
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
    const auto answer = reference->at(motion.t, {});
    ASSERT_TRUE(answer) << motion.name;
    EXPECT_LT(answer->error, 2e-14) << motion.name;
    const Matrix<double> Q = Eigen::Map<const RowMatrix>(motion.Q.data(), motion.n, motion.N);
    const double error = (answer->state.attitude.cast<double>() - Q).cwiseAbs().maxCoeff();
    EXPECT_LT(error, 2e-14) << motion.name;  // the initial frame is orthogonal to 1e-16 only
  }
}

/// The reference of every system reports the motion in the variables of that system.
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
      const bool by_series = system_entry(system.name)->motion != nullptr;
      EXPECT_TRUE(error.attitude || !by_series) << system.name;
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

/// The estimate is not below the true error.
TEST(Reference, SaysHowFarItIsOff) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Scene scene = testing::random_scene(4, seed, 10, "variational");
    const auto reference = make_reference(scene, {40, 1e12});
    const auto exact = testing::motion_in_quadruple(scene);
    for (const double t : {10.0, 20.0, 40.0}) {
      const auto answer = reference->at(t, {});
      ASSERT_TRUE(answer);
      EXPECT_LE(error_of(answer->state, exact(t)).largest(), answer->error) << seed;
      EXPECT_LT(answer->error, 1e-13) << seed;
    }
  }
}

/// For every system, at the start, soon after and later: the reference's own error is never 0, and
/// the reference differs from the motion in quadruple precision, where the tests have it, by no
/// more than the error it states.
TEST(Reference, OfNoSystemVouchesForItself) {
  for (const auto& system : catalogue().systems) {
    if (system.discrete || system_entry(system.name)->motion == nullptr) continue;
    const Scene scene =
        Scene::resolve(testing::any_scene(std::string(system.name), "rk4", 1, 0.1)).value();
    const auto reference = make_reference(scene, {20, 1e12});
    const auto exact = testing::motion_in_quadruple(scene);
    EXPECT_NE(reference->description().find("Taylor series"), std::string::npos) << system.name;
    for (const double t : {1e-9, 1e-3, 0.1, 5.0, 20.0}) {
      const auto answer = reference->at(t, {});
      ASSERT_TRUE(answer) << system.name;
      if (exact) {
        const double difference = error_of(answer->state, exact(t)).largest();
        EXPECT_LE(difference, answer->error) << system.name << " at " << t;
      }
      EXPECT_LT(answer->error, 1e-11) << system.name << " at " << t;
      const double size = static_cast<double>(answer->state.attitude.cwiseAbs().maxCoeff());
      const double rounding = static_cast<double>(std::numeric_limits<long double>::epsilon());
      EXPECT_GE(answer->error, rounding * std::max(1.0, size)) << system.name << " at " << t;
    }
  }
}

TEST(Reference, OfABodyAtRestHasTheErrorOfRounding) {
  SceneDescription d = testing::description(testing::RandomBody(4, 1), 0.1, "rk4");
  d.initial["M"] = RowMatrix(RowMatrix::Zero(4, 4));
  const Scene scene = Scene::resolve(d).value();
  const auto answer = make_reference(scene, {100, 1e12})->at(100, {});
  ASSERT_TRUE(answer);
  EXPECT_GT(answer->error, 1e-19);
  EXPECT_LT(answer->error, 1e-17);
  EXPECT_EQ(answer->state.attitude.cast<double>(), scene.Q());
}

/// The start of a scene of (Q, P) is not rounded on the way to (Q, M): near the edge of Ψ⁻¹ and for
/// long the reference stays the motion of its own equations.
TEST(Reference, StartsFromTheScenesOwnBlocks) {
  for (const char* system : {"symmetric_rigid_body", "right_symmetric_rigid_body"}) {
    const bool right = std::string(system).starts_with("right");
    SceneDescription d = testing::any_scene("symmetric_rigid_body", "rk4", 5, 0.1);
    d.epsilon = 0.2;
    d.system = system;
    const Scene scene = Scene::resolve(d).value();
    const int N = scene.dimension();
    const Vector<Quad> lambda = scene.inertia().cast<Quad>();
    Matrix<Quad> x(2 * N, N);
    if (right)
      x << scene.Q().transpose().cast<Quad>(), scene.block("P").transpose().cast<Quad>();
    else
      x << scene.Q().cast<Quad>(), scene.block("P").cast<Quad>();
    const Quad epsilon(scene.epsilon());
    const auto M = [&](const Matrix<Quad>& of) -> Matrix<Quad> {
      const Matrix<Quad> G = of.topRows(N).transpose() * of.bottomRows(N);
      return (G - G.transpose()) / epsilon;
    };
    const auto field = [&](const Matrix<Quad>& of) -> Matrix<Quad> {
      Matrix<Quad> Omega = M(of);
      for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) Omega(i, j) /= lambda(i) + lambda(j);
      return of * Omega;
    };
    const double t = 60;
    x = testing::extrapolate(field, x, Quad(t), 480);
    MotionState exact{x.topRows(N).cast<long double>(), M(x).cast<long double>()};
    if (right) {
      exact.attitude.transposeInPlace();
      exact.momentum *= -1;
    }
    const auto answer = make_reference(scene, {t, 1e12})->at(t, {});
    ASSERT_TRUE(answer);
    EXPECT_LE(error_of(answer->state, exact).largest(), answer->error) << system;
    EXPECT_LT(answer->error, 1e-14) << system;
  }
}

/// [ST] (9), (14): the costate of a point on the ellipsoid has a part along q, which is not motion.
TEST(Reference, OfACostateIsTheMotionOfItsOwnEquations) {
  const testing::RandomFrame<double> frame(1, 4, 5);
  SceneDescription d;
  d.system = "ellipsoid";
  d.method = MethodDescription{"rk4", {}, {}, "", {}};
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial["q"] = RowMatrix(frame.Q);
  d.initial["p"] = RowMatrix(frame.S + 0.7 * frame.Q);
  d.step = 0.1;
  const Scene scene = Scene::resolve(d).value();
  const Vector<Quad> lambda = scene.inertia().cast<Quad>(), inverse = lambda.cwiseInverse();
  const auto field = [&](const Matrix<Quad>& x) -> Matrix<Quad> {
    const Vector<Quad> q = x.row(0).transpose(), p = x.row(1).transpose();
    const Matrix<Quad> M = q * p.transpose() - p * q.transpose();
    const Matrix<Quad> U =
        inverse.asDiagonal() * M * inverse.asDiagonal() / q.dot(inverse.cwiseProduct(q));
    const Matrix<Quad> qq = q * q.transpose(), W = U * lambda.asDiagonal() * U;
    Matrix<Quad> rate(2, 4);
    rate << -(U * q).transpose(), ((qq * W - W * qq) * q - U * p).transpose();
    return rate;
  };
  Matrix<Quad> x(2, 4);
  const Vector<Quad> q = scene.block("q").row(0).transpose().cast<Quad>();
  x << (q / sqrt(Quad(q.squaredNorm()))).transpose(), scene.block("p").cast<Quad>();
  const double t = 20;
  x = testing::extrapolate(field, x, Quad(t), 200);
  const Matrix<Quad> velocity = field(x).topRows(1) * lambda.asDiagonal();
  const MotionState exact{x.topRows(1).cast<long double>(), velocity.cast<long double>()};
  const auto answer = make_reference(scene, {t, 1e12})->at(t, {});
  ASSERT_TRUE(answer);
  EXPECT_LE(error_of(answer->state, exact).largest(), answer->error);
  EXPECT_LT(answer->error, 1e-14);
}

TEST(MotionError, OfComplexMatricesIsTheLargestModulus) {
  SceneDescription d = testing::any_scene("double_bracket", "rk4", 1, 0.1);
  const Scene scene = Scene::resolve(d).value();
  d.initial["Q"].values(1, 2) += 3e-3;
  d.initial["Q"].imaginary(1, 2) -= 4e-3;
  d.initial["P"].values(0, 1) -= 12e-3;
  d.initial["P"].imaginary(0, 1) += 5e-3;
  const Scene other = Scene::resolve(d).value();
  const MotionState exact = read_motion(scene, *make_simulation(scene));
  const MotionState state = read_motion(other, *make_simulation(other));
  const MotionError error = error_of(state, exact);
  EXPECT_NEAR(*error.attitude, 5e-3, 1e-15);
  double size = 0;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 3; ++j)
      size = std::max(size, std::hypot(scene.block("P")(i, j), scene.block("P")(i + 2, j)));
  EXPECT_NEAR(error.momentum, 13e-3 / size, 1e-15);
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
