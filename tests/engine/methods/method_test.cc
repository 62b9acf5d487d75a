#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engine/linalg/lie/orthogonal.h"
#include "engine/methods/crouch_grossman3.h"
#include "engine/methods/gauss4.h"
#include "engine/methods/implicit_midpoint.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/variational.h"
#include "engine/rigid_body/body/body_invariants.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "tests/support/exact_motion.h"
#include "tests/support/scenes/body_state.h"

namespace stiefel {
namespace {

using testing::RandomBody;

template <class Method, class Space>
using MapOn = typename Method::template Map<RigidBody<Space>>;

/// A method at an order on a space.
template <class M, class Space_, int dimension, int order_>
struct Case {
  using Method = M;
  using Space = Space_;
  using Stepper = MapOn<M, Space>;
  static constexpr int N = dimension, order = order_;
  static auto map(const RandomBody& body, double h) {
    return Stepper(RigidBody<Space>(body.lambda), h, order);
  }
};
template <class T>
class OnBodies : public ::testing::Test {};

using In3 = So3<double, true>;
using InN = SoN<double>;
using Cases = ::testing::Types<Case<CrouchGrossman3, In3, 3, 3>, Case<CrouchGrossman3, InN, 4, 3>,
                               Case<CrouchGrossman3, InN, 7, 3>, Case<ImplicitMidpoint, In3, 3, 2>,
                               Case<ImplicitMidpoint, InN, 4, 2>, Case<ImplicitMidpoint, InN, 7, 2>,
                               Case<Gauss4, In3, 3, 4>, Case<Gauss4, InN, 4, 4>,
                               Case<Gauss4, InN, 7, 4>, Case<Variational, In3, 3, 4>,
                               Case<Variational, InN, 4, 4>, Case<Variational, InN, 5, 6>>;
TYPED_TEST_SUITE(OnBodies, Cases);

template <class Stepper, class State>
void advance(Stepper& map, State& state, int steps) {
  for (int k = 0; k < steps; ++k) ASSERT_TRUE(map.step(state).reached());
}

TYPED_TEST(OnBodies, HasItsOrder) {
  constexpr int coarse = TypeParam::order > 4 ? 8 : 40;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const RandomBody body(TypeParam::N, seed);
    const auto exact = testing::exact_motion(body.lambda, body.Q, body.M, 1);
    const auto error = [&](int steps) {
      auto map = TypeParam::map(body, 1.0 / steps);
      auto state = map.start(testing::state_of<typename TypeParam::Space>(body));
      advance(map, state, steps);
      return (testing::frame_of(state.x.value) - exact.Q).norm();
    };
    EXPECT_NEAR(std::log2(error(coarse) / error(2 * coarse)), TypeParam::order, 0.1) << seed;
  }
}

TYPED_TEST(OnBodies, IsReversibleAsDeclared) {
  const RandomBody body(TypeParam::N, 9);
  const auto start = testing::state_of<typename TypeParam::Space>(body);
  auto there = TypeParam::map(body, 0.1), back = TypeParam::map(body, -0.1);
  auto out = there.start(start);
  advance(there, out, 100);
  auto home = back.start(out.x.value);
  advance(back, home, 100);
  const double error = (home.x.value - start).norm();
  if (TypeParam::Method::traits.reversible)
    EXPECT_LT(error, 1e-12);
  else
    EXPECT_GT(error, 1e-9);
}

TYPED_TEST(OnBodies, GoesOnWithTheSameBits) {
  const RandomBody body(TypeParam::N, 5);
  auto map = TypeParam::map(body, 0.1);
  auto state = map.start(testing::state_of<typename TypeParam::Space>(body));
  advance(map, state, 7);
  const auto saved = testing::numbers_of(state);
  advance(map, state, 9);
  auto other_map = TypeParam::map(body, 0.1);
  auto other =
      other_map.start(testing::state_of<typename TypeParam::Space>(RandomBody(TypeParam::N, 6)));
  testing::put_back(saved, other);
  advance(other_map, other, 9);
  EXPECT_EQ(testing::numbers_of(state), testing::numbers_of(other));
}

/// The drift of energy, spatial momentum, casimirs, a Manakov coefficient (of μ in tr(M + μΛ²)³)
/// and orthogonality, relative to their scales.
using Drift = Eigen::Array<double, 5, 1>;
constexpr std::array<const char*, 5> invariants = {"energy", "spatial_momentum", "casimirs",
                                                   "manakov", "orthogonality"};

Drift drift(const RandomBody& body, const Eigen::MatrixXd& Q, const Eigen::MatrixXd& M) {
  const double size = body.M.norm();
  const auto coefficient = [&](const Eigen::MatrixXd& at) {
    return manakov<double>(body.lambda, at, 3)[3][1];
  };
  return Drift{
      energy<double>(body.lambda, M) / energy<double>(body.lambda, body.M) - 1,
      (spatial_momentum<double>(Q, M) - spatial_momentum<double>(body.Q, body.M)).norm() / size,
      (casimirs<double>(M) - casimirs<double>(body.M)).norm() / size,
      (coefficient(M) - coefficient(body.M)) / (3 * size * size * body.lambda.cwiseAbs2().norm()),
      orthogonality_defect(Q)}
      .abs();
}

/// The worst in the first tenth, the first half and the second half of a run.
struct Growth {
  Drift tenth = Drift::Zero(), first = Drift::Zero(), second = Drift::Zero();
  void include(const Drift& d, int sample, int samples) {
    if (10 * sample <= samples) tenth = tenth.max(d);
    (2 * sample <= samples ? first : second) = (2 * sample <= samples ? first : second).max(d);
  }
};

void expect_conservation(Conservation conservation, const Growth& growth, int i, const char* name) {
  if (conservation == Conservation::exact) {
    EXPECT_LE(growth.second(i), 1e-12) << name;
  } else if (conservation == Conservation::drifts) {
    EXPECT_GE(growth.second(i), 3 * growth.tenth(i)) << name;
    EXPECT_GE(growth.second(i), 1e-9) << name;
  } else {
    EXPECT_LE(growth.second(i), 2 * growth.first(i)) << name;
    EXPECT_GE(growth.second(i), 1e-9) << name << " would be exact";
  }
}

/// 10⁴ steps of 32 seeded bodies, fewer for methods with costly steps.
TYPED_TEST(OnBodies, KeepsWhatItDeclares) {
  using Method = typename TypeParam::Method;
  using Body = RigidBody<typename TypeParam::Space>;
  constexpr bool costly = std::is_same_v<Method, Variational> || TypeParam::N > 4;
  constexpr int samples = 20, steps = costly ? 1000 : 10000;
  Growth growth;
  for (unsigned seed = 1; seed <= 32; ++seed) {
    const RandomBody body(TypeParam::N, seed);
    auto map = TypeParam::map(body, 0.1);
    auto state = map.start(testing::state_of<typename TypeParam::Space>(body));
    for (int k = 1; k <= samples; ++k) {
      advance(map, state, steps / samples);
      const auto& x = state.x.value;
      growth.include(drift(body, testing::frame_of(x), testing::momentum_of(x)), k, samples);
    }
  }
  for (int i = 0; i < 5; ++i)
    expect_conservation(conservation_by<Method, Body>(invariants[i]), growth, i, invariants[i]);
}

/// [RB] (3.1): Q̇ = QΩ, Ṗ = PΩ, M = QᵀP − PᵀQ.
struct QuadraticBody {
  using Scalar = double;
  using State = Eigen::MatrixXd;
  static constexpr const char* name = "quadratic_body";
  /// QQᵀ and m = PQᵀ − QPᵀ, which has the eigenvalues of M.
  static constexpr bool quadratic(std::string_view invariant) {
    return invariant != "energy" && invariant != "manakov";
  }
  Eigen::VectorXd lambda;

  Eigen::MatrixXd M(const State& x) const {
    const Eigen::Index N = x.cols();
    const Eigen::MatrixXd A = x.topRows(N).transpose() * x.bottomRows(N);
    return A - A.transpose();
  }
  void field(const State& x, State& dx) const {
    Eigen::MatrixXd Omega(x.cols(), x.cols());
    SoN<double>::inverse_inertia(lambda, M(x), Omega);
    dx = x * Omega;
  }
};

TEST(Gauss4, KeepsQuadraticInvariants) {
  constexpr int N = 4, samples = 20, steps = 2000;
  Growth growth;
  for (unsigned seed = 1; seed <= 32; ++seed) {
    const RandomBody body(N, seed);
    const QuadraticBody system{body.lambda};
    Gauss4::Map<QuadraticBody> map(system, 0.1, 4);
    Eigen::MatrixXd x(2 * N, N);
    x << body.Q, body.Q * body.M / 2;  // QᵀP skew: M = QᵀP − PᵀQ
    auto state = map.start(x);
    for (int k = 1; k <= samples; ++k) {
      advance(map, state, steps / samples);
      const Eigen::MatrixXd Q = state.x.value.topRows(N);
      growth.include(drift(body, Q, system.M(state.x.value)), k, samples);
    }
  }
  for (int i = 0; i < 5; ++i)
    expect_conservation(conservation_by<Gauss4, QuadraticBody>(invariants[i]), growth, i,
                        invariants[i]);
}

/// A step that no solver reaches, of a body whose λ spread over 1 : 1e10, leaves every bit, solver
/// history included. (That what a LEFT_DOMAIN names is the edge is seen in tests/extremes.)
template <class T>
void expect_untouched(double small, double h) {
  const RandomBody body(T::N, 3, 1e10);
  auto map = T::map(body, small), large = T::map(body, h);
  auto state = map.start(testing::state_of<typename T::Space>(body));
  advance(map, state, 6);
  const auto before = testing::numbers_of(state);
  const RunStatus status = large.step(state);
  ASSERT_TRUE(status.outcome == Outcome::left_domain || status.outcome == Outcome::solver_stalled);
  EXPECT_EQ(testing::numbers_of(state), before);
  EXPECT_EQ(status.outcome == Outcome::left_domain, status.largest_step.has_value());
  if (status.largest_step) {
    EXPECT_LT(*status.largest_step, h);
  }
}
TEST(ImplicitMethods, LeaveTheStateWhenTheyFail) {
  expect_untouched<Case<Gauss4, In3, 3, 4>>(1e-11, 3);
  expect_untouched<Case<Gauss4, InN, 5, 4>>(1e-11, 3);
  expect_untouched<Case<ImplicitMidpoint, InN, 5, 2>>(1e-11, 3);
}

}  // namespace
}  // namespace stiefel
