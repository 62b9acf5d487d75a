#include <gtest/gtest.h>

#include <cmath>

#include "engine/linalg/lie/orthogonal.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/rigid_body/body/body_invariants.h"
#include "engine/rigid_body/body/right_rigid_body.h"
#include "engine/rigid_body/body/rigid_body.h"
#include "engine/rigid_body/symmetric/mclachlan_scovel.h"
#include "engine/rigid_body/symmetric/psi.h"
#include "engine/rigid_body/symmetric/reduced_rigid_body.h"
#include "engine/rigid_body/symmetric/right_symmetric_rigid_body.h"
#include "engine/rigid_body/symmetric/symmetric_invariants.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"
#include "tests/support/flow.h"
#include "tests/support/linalg/dual.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"

namespace stiefel {
namespace {

using namespace testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using DualMatrix = Matrix<Dual>;

/// (Q, M) of the left-invariant body in the variables of one form, and back. `system<Scalar>` is
/// the form's System for the motion that starts there.
struct Body {
  VectorXd lambda;
  MatrixXd Q, M;
  double epsilon;
  Eigen::Index N() const { return lambda.size(); }
};

MatrixXd top(const MatrixXd& x) { return x.topRows(x.cols()); }
MatrixXd bottom(const MatrixXd& x) { return x.bottomRows(x.cols()); }

struct Right {
  template <class Scalar>
  static RightRigidBody<Scalar> system(const Body& b) {
    return RightRigidBody<Scalar>(b.lambda.cast<Scalar>());
  }
  static MatrixXd from(const Body& b) { return stacked(b.Q.transpose(), -b.M); }
  static MatrixXd Q(const Body&, const MatrixXd& x) { return top(x).transpose(); }
  static MatrixXd M(const Body&, const MatrixXd& x) { return -bottom(x); }
};
struct Symmetric {
  template <class Scalar>
  static SymmetricRigidBody<Scalar> system(const Body& b) {
    return SymmetricRigidBody<Scalar>(b.lambda.cast<Scalar>(), static_cast<Scalar>(b.epsilon));
  }
  static MatrixXd from(const Body& b) { return stacked(b.Q, symmetric_P(b.Q, b.M, b.epsilon)); }
  static MatrixXd Q(const Body&, const MatrixXd& x) { return top(x); }
  static MatrixXd M(const Body& b, const MatrixXd& x) {
    return Psi<double>(top(x), bottom(x), b.epsilon);
  }
};
struct RightSymmetric {
  template <class Scalar>
  static RightSymmetricRigidBody<Scalar> system(const Body& b) {
    return RightSymmetricRigidBody<Scalar>(b.lambda.cast<Scalar>(), static_cast<Scalar>(b.epsilon));
  }
  static MatrixXd from(const Body& b) {
    return stacked(b.Q.transpose(), symmetric_P(b.Q, b.M, b.epsilon).transpose());
  }
  static MatrixXd Q(const Body&, const MatrixXd& x) { return top(x).transpose(); }
  static MatrixXd M(const Body& b, const MatrixXd& x) {
    return Psi<double>(top(x).transpose(), bottom(x).transpose(), b.epsilon);
  }
};
struct Reduced {
  template <class Scalar>
  static ReducedRigidBody<Scalar> system(const Body& b) {
    return {b.lambda.cast<Scalar>(), A(b).cast<Scalar>(), static_cast<Scalar>(b.epsilon)};
  }
  static MatrixXd A(const Body& b) {
    return constant_A<double>(b.Q, symmetric_P(b.Q, b.M, b.epsilon));
  }
  static MatrixXd from(const Body& b) { return b.Q; }
  static MatrixXd Q(const Body&, const MatrixXd& x) { return x; }
  static MatrixXd M(const Body& b, const MatrixXd& x) {
    return Psi<double>(x, system<double>(b).P(x), b.epsilon);
  }
};
struct McLachlan {
  template <class Scalar>
  static McLachlanScovel<Scalar> system(const Body& b) {
    return McLachlanScovel<Scalar>(b.lambda.cast<Scalar>());
  }
  static MatrixXd from(const Body& b) { return stacked(b.Q, b.Q * b.M); }
  static MatrixXd Q(const Body&, const MatrixXd& x) { return top(x); }
  static MatrixXd M(const Body&, const MatrixXd& x) { return top(x).transpose() * bottom(x); }
};

template <class Form>
class RigidForm : public ::testing::Test {};
using Forms = ::testing::Types<Right, Symmetric, RightSymmetric, Reduced, McLachlan>;
TYPED_TEST_SUITE(RigidForm, Forms);

Body random_body(int N, unsigned seed) {
  const RandomBody body(N, seed);
  return {body.lambda, body.Q, body.M, epsilon_for(body.M)};
}

template <class Form>
using SystemOf = decltype(Form::template system<double>(std::declval<Body>()));

template <class Form>
MatrixXd by_munthe_kaas4(const Body& body, double t, int steps) {
  MuntheKaas4::Map<SystemOf<Form>> map(Form::template system<double>(body), t / steps, 4);
  auto state = map.start(Form::from(body));
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(state).reached());
  return state.x.value;
}

TYPED_TEST(RigidForm, ReproducesTheReference) {
  for (const ReferenceCase& c : reference_cases("rigid_body")) {
    Body body{c.vector("inertia"), c.matrix("Q0"), c.matrix("M0"), 0};
    body.epsilon = epsilon_for(body.M);
    const bool hard = c.name().find("wide") != std::string::npos ||
                      c.name().find("intermediate") != std::string::npos;
    const MatrixXd x =
        flow(TypeParam::template system<long double>(body), TypeParam::from(body), c.number("t"));
    // The hard ones magnify the rounding of P (200 at Λ = 1:10⁵, 10⁴ away from the axis).
    const double bound = hard ? 1e-9 : 1e-10;
    EXPECT_LT((TypeParam::Q(body, x) - c.matrix("Q")).norm(), bound) << c.name();
    EXPECT_LT((TypeParam::M(body, x) - c.matrix("M")).norm(), bound * c.matrix("M").norm())
        << c.name();
    if (hard) continue;
    const MatrixXd y = by_munthe_kaas4<TypeParam>(body, c.number("t"), 2000);
    EXPECT_LT((TypeParam::Q(body, y) - c.matrix("Q")).norm(), bound) << c.name();
    EXPECT_LT((TypeParam::M(body, y) - c.matrix("M")).norm(), bound * c.matrix("M").norm())
        << c.name();
  }
}

/// This test detects a wrong sign of the bracket: Ω(t) does not commute with Ω(0).
TYPED_TEST(RigidForm, MuntheKaas4HasOrder4) {
  for (const int N : {3, 4, 6})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const Body body = random_body(N, seed);
      const MatrixXd exact =
          flow(TypeParam::template system<long double>(body), TypeParam::from(body), 1);
      const double coarse = (by_munthe_kaas4<TypeParam>(body, 1, 30) - exact).norm();
      const double fine = (by_munthe_kaas4<TypeParam>(body, 1, 60) - exact).norm();
      EXPECT_NEAR(std::log2(coarse / fine), 4, 0.15) << N << " " << seed << " " << coarse;
    }
}

/// The generator and the group action make the vector field: x·exp(δξ) − x = δX + O(δ²).
TYPED_TEST(RigidForm, FieldIsTheGeneratorsAction) {
  const Body body = random_body(5, 4);
  auto system = TypeParam::template system<double>(body);
  const MatrixXd x = TypeParam::from(body);
  MatrixXd xi = system.zero(), ahead = x, behind = x, field = x;
  constexpr double delta = 1e-5;
  system.generator(x, xi);
  system.displacement(x, delta * xi, ahead);
  system.displacement(x, -delta * xi, behind);
  system.field(x, field);
  EXPECT_LT(((ahead - behind) / (2 * delta) - field).norm(), 1e-9 * field.norm());
}

/// d/dt of I(x) along the field at x is exact; it vanishes up to rounding of what I is made of.
template <class Form, class Invariant>
void expect_constant(const Body& body, const MatrixXd& x, Invariant invariant, double scale) {
  auto system = Form::template system<double>(body);
  MatrixXd dx = x;
  system.field(x, dx);
  const DualMatrix I = invariant(dual(x, dx));
  for (const Dual& i : I.reshaped()) EXPECT_LT(std::abs(i.rate), 16 * 0x1p-53 * scale) << i.value;
}

/// The coefficients of μ^j in tr((M + μΛ²)^k), each by its scale C(k, j)‖M‖^{k−j}‖Λ²‖^j.
DualMatrix scaled(const std::vector<std::vector<Dual>>& coefficients, double M, double lambda2) {
  DualMatrix column(0, 1);
  for (std::size_t k = 1; k < coefficients.size(); ++k)
    for (std::size_t j = 0; j <= k; ++j) {
      const double binomial = 1 / ((static_cast<double>(k) + 1) *
                                   std::beta(static_cast<double>(k - j) + 1, double(j) + 1));
      column.conservativeResize(column.rows() + 1, 1);
      column(column.rows() - 1) =
          coefficients[k][j] / (binomial * std::pow(M, k - j) * std::pow(lambda2, j));
    }
  return column;
}

/// Orthogonal matrices without any relation, so ‖M‖_op up to 2/ε.
TEST(Invariants, OfTheSymmetricFormsAreConstantAtEveryState) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const int N = 3 + static_cast<int>(seed % 4);
    Body body = random_body(N, seed);
    const Vector<Dual> lambda = body.lambda.cast<Dual>();
    const double speed = 2 / body.epsilon, lambda2 = std::pow(body.lambda.maxCoeff(), 2);
    const MatrixXd x = stacked(body.Q, RandomBody(N, seed + 1000).Q);
    const Dual epsilon = body.epsilon;
    const auto Q = [](const DualMatrix& y) { return DualMatrix(y.topRows(y.cols())); };
    const auto P = [](const DualMatrix& y) { return DualMatrix(y.bottomRows(y.cols())); };
    const auto E = [&](const DualMatrix& M) {
      return DualMatrix(DualMatrix::Constant(1, 1, energy<Dual>(lambda, M)));
    };
    expect_constant<Symmetric>(
        body, x, [&](const auto& y) { return constant_A<Dual>(Q(y), P(y)); }, N * speed);
    expect_constant<Symmetric>(
        body, x, [&](const auto& y) { return E(Psi<Dual>(Q(y), P(y), epsilon)); },
        N * speed * speed * speed);
    expect_constant<Symmetric>(
        body, x, [&](const auto& y) { return DualMatrix(Q(y) * Q(y).transpose()); }, N * speed);
    expect_constant<Symmetric>(
        body, x,
        [&](const auto& y) {
          return scaled(reduced_manakov<Dual>(lambda, Q(y), constant_A<Dual>(Q(y), P(y)), N), 2,
                        lambda2);
        },
        N * N * speed);
    expect_constant<RightSymmetric>(
        body, x, [&](const auto& y) { return DualMatrix(Q(y).transpose() * P(y)); }, N * speed);
    expect_constant<RightSymmetric>(
        body, x,
        [&](const auto& y) { return E(Psi<Dual>(Q(y).transpose(), P(y).transpose(), epsilon)); },
        N * speed * speed * speed);
    body.M = RandomBody(N, seed + 2000).M;
    const DualMatrix A = Reduced::A(body).cast<Dual>();
    expect_constant<Reduced>(
        body, body.Q,
        [&](const auto& y) { return scaled(reduced_manakov<Dual>(lambda, y, A, N), 2, lambda2); },
        N * N * speed);
    expect_constant<Reduced>(
        body, body.Q, [&](const auto& y) { return E(y.transpose() * (A - A.transpose()) * y); },
        N * speed * speed * speed);
  }
}

TEST(Invariants, OfTheOtherFormsAreConstantAtEveryState) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const int N = 3 + static_cast<int>(seed % 4);
    const Body body = random_body(N, seed);
    const Vector<Dual> lambda = body.lambda.cast<Dual>();
    const double m = operator_norm(body.M), lambda2 = std::pow(body.lambda.maxCoeff(), 2);
    const auto first = [](const DualMatrix& y) { return DualMatrix(y.topRows(y.cols())); };
    const auto second = [](const DualMatrix& y) { return DualMatrix(y.bottomRows(y.cols())); };
    expect_constant<Right>(
        body, Right::from(body),
        [&](const auto& y) { return right_momentum<Dual>(first(y), second(y)); }, N * m);
    expect_constant<Right>(
        body, Right::from(body),
        [&](const auto& y) {
          const Vector<Dual> squares = lambda.cwiseProduct(lambda);
          return scaled(pencil_traces<Dual>(second(y), squares.asDiagonal(), N), m, lambda2);
        },
        N * N);
    expect_constant<McLachlan>(
        body, McLachlan::from(body),
        [&](const auto& y) { return constant_A<Dual>(first(y), second(y)); }, N * m);
    expect_constant<McLachlan>(
        body, McLachlan::from(body),
        [&](const auto& y) {
          const DualMatrix M = first(y).transpose() * second(y);
          DualMatrix both(1, 2);
          both << energy<Dual>(lambda, M), (M + M.transpose()).squaredNorm();
          return both;
        },
        N * m * m);
  }
}

TEST(Invariants, ReducedManakovIsManakovOfM) {
  const Body body = random_body(5, 6);
  const auto reduced = reduced_manakov<double>(body.lambda, body.Q, Reduced::A(body), 5);
  const auto plain = manakov<double>(body.lambda, body.epsilon * body.M, 5);
  for (std::size_t k = 1; k <= 5; ++k)
    for (std::size_t j = 0; j <= k; ++j)
      EXPECT_NEAR(reduced[k][j], plain[k][j], 1e-13 * std::pow(32.0, k)) << k << " " << j;
}

/// One exponential moves both factors, so PQᵀ and Q_rᵀP_r stay for any error of the motion.
TEST(SymmetricRigidBody, MuntheKaas4KeepsPQtOverTenThousandSteps) {
  const Body body = random_body(4, 2);
  constexpr int steps = 10'000;
  constexpr double h = 0.2, bound = 1e-13;
  const MatrixXd A = Reduced::A(body);

  const MatrixXd x = by_munthe_kaas4<Symmetric>(body, steps * h, steps);
  EXPECT_LT((constant_A<double>(top(x), bottom(x)) - A).cwiseAbs().maxCoeff(), bound);
  EXPECT_LT(orthogonality_defect(top(x)), bound);
  EXPECT_LT(orthogonality_defect(bottom(x)), bound);
  EXPECT_GT(std::abs(energy<double>(body.lambda, Symmetric::M(body, x)) -
                     energy<double>(body.lambda, body.M)),
            1e-9);  // the energy is not kept: the step is not small

  const MatrixXd y = by_munthe_kaas4<RightSymmetric>(body, steps * h, steps);
  EXPECT_LT((top(y).transpose() * bottom(y) - A.transpose()).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(RightRigidBody, MovesAMomentumWithoutAFrame) {
  const Body body = random_body(5, 3);
  using Map = MuntheKaas4::Map<RightRigidBody<double>>;
  Map with(RightRigidBody<double>(body.lambda), 0.1, {4, Arithmetic::plain}), without = with;
  auto both = with.start(Right::from(body));
  auto alone = without.start(-body.M);
  for (int k = 0; k < 20; ++k) {
    ASSERT_TRUE(with.step(both).reached());
    ASSERT_TRUE(without.step(alone).reached());
  }
  EXPECT_LT((bottom(both.x.value) - alone.x.value).norm(), 1e-14);
}

}  // namespace
}  // namespace stiefel
