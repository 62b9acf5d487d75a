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
#include "tests/support/integrate.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"
#include "tests/support/scenes/stacked.h"

namespace stiefel {
namespace {

using testing::bottom;
using testing::top;
using namespace testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// (Q, M) of the left-invariant body in the variables of one form, and back. `system<Scalar>` is
/// the form's System for the motion that starts there.
struct Body {
  VectorXd lambda;
  MatrixXd Q, M;
  double epsilon;
  Eigen::Index N() const { return lambda.size(); }
};

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
