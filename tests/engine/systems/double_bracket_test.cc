#include "engine/double_bracket/double_bracket.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/double_bracket/double_bracket_invariants.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/rigid_body/body/body_invariants.h"
#include "engine/rigid_body/symmetric/right_symmetric_rigid_body.h"
#include "engine/rigid_body/symmetric/symmetric_rigid_body.h"
#include "tests/support/flow.h"
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

/// (5.8), (5.9) in complex matrices, as they are printed.
Pair printed_field(const VectorXd& lambda_u, const VectorXd& lambda_v, const Pair& at) {
  const auto over_sums = [](const VectorXd& lambda, ComplexMatrix X) {
    for (Eigen::Index i = 0; i < X.rows(); ++i)
      for (Eigen::Index j = 0; j < X.cols(); ++j) X(i, j) /= lambda(i) + lambda(j);
    return X;
  };
  const auto& [Q, P] = at;
  const ComplexMatrix U = over_sums(lambda_u, P * Q.adjoint() - Q * P.adjoint());
  const ComplexMatrix V = over_sums(lambda_v, P.adjoint() * Q - Q.adjoint() * P);
  return {U * Q - Q * V, U * P - P * V};
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

TEST(DoubleBracket, FieldIsThePrintedOneAndTheDoubleBracket) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Problem problem(2, 4, seed);
    const Eigen::Index p = 2, q = 4;
    const Pair printed = printed_field(problem.lambda_u, problem.lambda_v, problem.start);
    MatrixXd field = state(problem.start);
    system<double>(problem.lambda_u, problem.lambda_v).field(state(problem.start), field);
    EXPECT_LT((field - state(printed)).norm(), 1e-14 * field.norm());

    // (5.10), (5.11)
    const auto hat = [&](const ComplexMatrix& Z) {
      ComplexMatrix Z_hat = ComplexMatrix::Zero(p + q, p + q);
      Z_hat.topRightCorner(p, q) = Z;
      Z_hat.bottomLeftCorner(q, p) = -Z.adjoint();
      return Z_hat;
    };
    const auto bracket = [](const ComplexMatrix& A, const ComplexMatrix& B) {
      return ComplexMatrix(A * B - B * A);
    };
    const ComplexMatrix Q = hat(problem.start.Q), P = hat(problem.start.P);
    VectorXd lambda(p + q);
    lambda << problem.lambda_u, problem.lambda_v;
    ComplexMatrix J_inverse = bracket(P, Q);
    for (Eigen::Index i = 0; i < p + q; ++i)
      for (Eigen::Index j = 0; j < p + q; ++j) J_inverse(i, j) /= lambda(i) + lambda(j);
    EXPECT_LT((bracket(Q, J_inverse) - hat(printed.Q)).norm(), 1e-13);
    EXPECT_LT((bracket(P, J_inverse) - hat(printed.P)).norm(), 1e-13);
  }
}

TEST(DoubleBracket, MuntheKaas4HasOrder4) {
  for (const auto& [p, q] : {std::pair(2, 3), std::pair(3, 2), std::pair(3, 3)})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const Problem problem(p, q, seed);
      const MatrixXd x = state(problem.start);
      const auto& [u, v] = std::tie(problem.lambda_u, problem.lambda_v);
      const MatrixXd exact = flow(system<long double>(u, v), x, 1);
      const double coarse = (by_munthe_kaas4(u, v, x, 1, 80) - exact).norm();
      const double fine = (by_munthe_kaas4(u, v, x, 1, 160) - exact).norm();
      EXPECT_NEAR(std::log2(coarse / fine), 4, 0.15) << p << q << " " << seed << " " << coarse;
    }
}

/// Differentials by hand: of ⅛ Σ |X_ij|²/(λ_i + λ_j), and of tr (Z†Z)^k, Z = aQ + bP, whose
/// coefficients are the singular values'.
TEST(DoubleBracket, InvariantsAreConstantAtEveryState) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const Problem problem(2 + static_cast<int>(seed % 2), 3, seed);
    const auto& [Q, P] = problem.start;
    MatrixXd field = state(problem.start);
    system<double>(problem.lambda_u, problem.lambda_v).field(state(problem.start), field);
    const auto [dQ, dP] = blocks(field);
    double rate = 0, size = 0;
    const auto add = [&](const VectorXd& lambda, const ComplexMatrix& X, const ComplexMatrix& dX) {
      for (Eigen::Index i = 0; i < X.rows(); ++i)
        for (Eigen::Index j = 0; j < X.cols(); ++j) {
          const double term =
              std::real(std::conj(X(i, j)) * dX(i, j)) / (4 * (lambda(i) + lambda(j)));
          rate += term;
          size += std::abs(term);
        }
    };
    const auto skew = [](const ComplexMatrix& G) { return ComplexMatrix(G - G.adjoint()); };
    add(problem.lambda_u, skew(P * Q.adjoint()), skew(dP * Q.adjoint() + P * dQ.adjoint()));
    add(problem.lambda_v, skew(P.adjoint() * Q), skew(dP.adjoint() * Q + P.adjoint() * dQ));
    EXPECT_LT(std::abs(rate), 1e-14 * (1 + size));

    for (const auto& [a, b] : {std::pair<Complex, Complex>(1, 0), {0, 1}, {{0.3, -1}, {2, 0.7}}}) {
      const ComplexMatrix Z = a * Q + b * P, dZ = a * dQ + b * dP;
      ComplexMatrix power = Z.adjoint();  // (Z†Z)^{k−1} Z†
      for (int k = 1; k <= 3; ++k) {
        EXPECT_LT(std::abs(std::real((power * dZ).trace())), 1e-14 * power.norm() * dZ.norm());
        power = (Z.adjoint() * Z * power).eval();
      }
    }
  }
}

TEST(DoubleBracket, KeepsSingularValuesAndTheEnergyOfTheLimits) {
  const Problem problem(2, 3, 7);
  const auto& [u, v] = std::tie(problem.lambda_u, problem.lambda_v);
  const Pair end = blocks(by_munthe_kaas4(u, v, state(problem.start), 50, 1000));
  const Complex a(0.4, -0.8), b(1.5, 0.2);
  for (const auto& [c, d] : {std::pair<Complex, Complex>(1, 0), {0, 1}, {a, b}})
    EXPECT_LT((singular_values<double>(end.Q, end.P, c, d) -
               singular_values<double>(problem.start.Q, problem.start.P, c, d))
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
    const MatrixXd right = flow(RightSymmetricRigidBody<long double>(lambda), real, 1);
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
