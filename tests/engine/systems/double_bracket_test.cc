#include "engine/bracket/double_bracket.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/body/body_invariants.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/methods/munthe_kaas4.h"
#include "tests/support/integrate.h"
#include "tests/support/reference_cases.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"

namespace stiefel {
namespace {

using namespace testing;
using Complex = std::complex<double>;
using ComplexMatrix = Matrix<Complex>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Pair {
  ComplexMatrix Q, P;
};

ComplexMatrix complex(const MatrixXd& re, const MatrixXd& im) {
  return re.cast<Complex>() + Complex(0, 1) * im.cast<Complex>();
}
MatrixXd state(const Pair& pair) {
  return stacked(stacked(pair.Q.real(), pair.Q.imag()), stacked(pair.P.real(), pair.P.imag()));
}
Pair blocks(const MatrixXd& x) {
  const Eigen::Index p = x.rows() / 4;
  return {complex(x.topRows(p), x.middleRows(p, p)),
          complex(x.middleRows(2 * p, p), x.bottomRows(p))};
}

/// Full random complex blocks and spread inertia.
struct Problem {
  VectorXd lambda_u, lambda_v;
  Pair start;

  Problem(int p, int q, unsigned seed) : lambda_u(p), lambda_v(q) {
    std::mt19937_64 generator(seed);
    const auto uniform = [&](double) { return 2 * std::generate_canonical<double, 53>(generator); };
    lambda_u = VectorXd::Zero(p).unaryExpr(uniform).array() + 1;
    lambda_v = VectorXd::Zero(q).unaryExpr(uniform).array() + 1;
    const auto block = [&] {
      return MatrixXd(MatrixXd::Zero(p, q).unaryExpr(uniform).array() - 1);
    };
    start.Q = complex(block(), block());
    start.P = complex(block(), block());
  }
};

template <class Scalar>
DoubleBracket<Scalar> system(const VectorXd& lambda_u, const VectorXd& lambda_v) {
  return {lambda_u.cast<Scalar>(), lambda_v.cast<Scalar>()};
}

MatrixXd by_munthe_kaas4(const VectorXd& lambda_u, const VectorXd& lambda_v, const MatrixXd& x,
                         double t, int steps) {
  MuntheKaas4::Map<DoubleBracket<double>> map(system<double>(lambda_u, lambda_v), t / steps, 4);
  auto at = map.start(x);
  for (int k = 0; k < steps; ++k) EXPECT_TRUE(map.step(at).reached());
  return at.x.value;
}

TEST(DoubleBracket, ReproducesTheReference) {
  for (const auto& c : reference_cases("double_bracket")) {
    const auto block = [&](const std::string& name) {
      return complex(c.matrix(name, "re"), c.matrix(name, "im"));
    };
    const VectorXd lambda_u = c.vector("inertia_u"), lambda_v = c.vector("inertia_v");
    const MatrixXd start = state({block("Q0"), block("P0")});
    const MatrixXd end = state({block("Q"), block("P")});
    const double t = c.number("t");
    EXPECT_LT((flow(system<long double>(lambda_u, lambda_v), start, t) - end).norm(), 1e-14);
    EXPECT_LT((by_munthe_kaas4(lambda_u, lambda_v, start, t, 1000) - end).norm(), 1e-11);
  }
}

TEST(DoubleBracket, KeepsSingularValuesAndTheEnergyOfTheLimits) {
  const Problem problem(2, 3, 7);
  const auto& [u, v] = std::tie(problem.lambda_u, problem.lambda_v);
  const Pair end = blocks(by_munthe_kaas4(u, v, state(problem.start), 50, 1000));
  const Complex a(0.4, -0.8), b(1.5, 0.2);
  for (const auto& [c, d] : {std::pair<Complex, Complex>(1, 0), {0, 1}, {a, b}})
    EXPECT_LT((singular_values(end.Q, end.P, c, d) -
               singular_values(problem.start.Q, problem.start.P, c, d))
                  .norm(),
              1e-13);
  const Pair exact = blocks(flow(system<long double>(u, v), state(problem.start), 5));
  const double H = double_bracket_hamiltonian<double>(u, v, problem.start.Q, problem.start.P);
  EXPECT_NEAR(double_bracket_hamiltonian<double>(u, v, exact.Q, exact.P), H, 1e-14 * H);

  const RandomBody body(4, 3);
  const double epsilon = epsilon_for(body.M);
  const ComplexMatrix Q = body.Q.cast<Complex>(),
                      P = symmetric_P(body.Q, body.M, epsilon).cast<Complex>();
  const VectorXd huge = VectorXd::Constant(4, 1e30);
  const double half = energy<double>(body.lambda, epsilon * body.M) / 2;
  EXPECT_NEAR(double_bracket_hamiltonian<double>(huge, body.lambda, Q, P), half, 1e-14);
  EXPECT_NEAR(double_bracket_hamiltonian<double>(body.lambda, huge, Q.adjoint(), P.adjoint()), half,
              1e-14);
}

/// J_U = s → ∞ is the left rigid body, J_V = s → ∞ the right one, at the rate 1/s.
TEST(DoubleBracket, LimitsAreTheRigidBodies) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const RandomBody body(3, seed);
    const MatrixXd P = RandomBody(3, seed + 100).Q, none = MatrixXd::Zero(3, 3);
    const MatrixXd real = stacked(body.Q, P);
    const MatrixXd start = stacked(stacked(body.Q, none), stacked(P, none));
    const Vector<long double> lambda = body.lambda.cast<long double>();
    const MatrixXd left = flow(SymmetricRigidBody<long double>(lambda), real, 1);
    const auto transposed = [](const MatrixXd& x) {
      return stacked(x.topRows(3).transpose(), x.bottomRows(3).transpose());
    };
    const MatrixXd right =
        transposed(flow(SymmetricRigidBody<long double>(lambda), transposed(real), 1));
    const auto distance = [&](double s, bool to_left) {
      const VectorXd large = VectorXd::Constant(3, s);
      const Pair end = blocks(to_left ? flow(system<long double>(large, body.lambda), start, 1)
                                      : flow(system<long double>(body.lambda, large), start, 1));
      EXPECT_EQ(end.Q.imag().norm() + end.P.imag().norm(), 0);
      return (stacked(end.Q.real(), end.P.real()) - (to_left ? left : right)).norm();
    };
    for (const bool to_left : {true, false}) {
      const double near = distance(1e4, to_left), nearer = distance(1e6, to_left);
      EXPECT_LT(near * 1e4, 5) << seed;
      EXPECT_NEAR(near / nearer, 100, 1) << seed;
      EXPECT_LT(distance(1e14, to_left), 1e-12) << seed;
    }
  }
}

}  // namespace
}  // namespace stiefel
