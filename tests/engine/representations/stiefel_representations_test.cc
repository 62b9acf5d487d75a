#include <gtest/gtest.h>

#include "engine/dense/decompositions.h"
#include "engine/frame/stiefel_momenta.h"
#include "tests/support/representations/frame_formulas.h"
#include "tests/support/representations/rigid_formulas.h"
#include "tests/support/scenes/random_matrices.h"

namespace stiefel {
namespace {

using testing::largest;
using Random = testing::RandomMatrices<double>;
using D = Matrix<double>;

struct Case {
  int n, N;
};

/// A point of T*V(n, N): Q̇ = QU with a full random U ∈ so(N), and S = Q̇Λ.
struct Point {
  Vector<double> lambda;
  D Q, U, Qdot, S, M;
  Point(const Case& c, unsigned seed, double spread = 4) {
    Random random(seed);
    lambda = random.lambda(c.N, spread);
    Q = random.frame(c.n, c.N);
    U = random.skew(c.N);
    Qdot = Q * U;
    S = S_of_Qdot(lambda, Qdot);
    const D K = Q.transpose() * Q;
    M = K * U * lambda.asDiagonal() + lambda.asDiagonal() * U * K;  // J_Q(U), [ST] (44)
  }
};

class OnFrames : public ::testing::TestWithParam<Case> {
 protected:
  const Point p{GetParam(), 11};
};
INSTANTIATE_TEST_SUITE_P(Sizes, OnFrames,
                         ::testing::Values(Case{1, 2}, Case{1, 5}, Case{2, 4}, Case{3, 8},
                                           Case{4, 5}, Case{3, 3}, Case{5, 5}),
                         [](const auto& test) {
                           return std::string("V").append(std::to_string(test.param.n)) + "_" +
                                  std::to_string(test.param.N);
                         });

TEST_P(OnFrames, SAndQdotAreOneAnother) {
  EXPECT_LT(largest(Qdot_of_S(p.lambda, p.S) - p.Qdot), 1e-14);
  EXPECT_LT(testing::tangency_defect(p.lambda, p.Q, p.S), 1e-13);
  EXPECT_LT(largest(dense_M(p.Q, p.S) - p.M), 1e-13);
  if (p.Q.rows() == p.Q.cols()) {
    EXPECT_LT(largest(testing::M_of_Qdot(p.lambda, p.Q, p.Qdot) - p.M), 1e-13);
  }
}

/// Theorem 2: J_Q(U) = M and QU = Q̇, for every P with the momentum M.
TEST_P(OnFrames, TheoremTwoInvertsJ_Q) {
  const auto& [lambda, Q, U, Qdot, S, M] = p;
  Random random(3);
  const D k = random.matrix(Q.rows(), Q.rows());
  for (const D& P : {S, Xi(Q, S), D(S + (k + k.transpose()) * Q)}) {
    OptimalControl<double> control(lambda, Q.rows());
    control.set(Q, P);
    const D V = control.dense(), QtQ = Q.transpose() * Q;
    EXPECT_LT(largest(V + V.transpose()), 1e-14);
    EXPECT_LT(largest(QtQ * V * lambda.asDiagonal() + lambda.asDiagonal() * V * QtQ - M), 1e-12);
    D QU = Q;
    control.apply(Q, QU);
    EXPECT_LT(largest(QU - Qdot), 1e-12);
    const D probe = random.matrix(Q.rows(), Q.cols());
    control.apply(probe, QU);
    EXPECT_LT(largest(QU - probe * V), 1e-12);
  }
}

/// Ξ leaves m and M, and ends in W⁰; (77)–(81).
TEST_P(OnFrames, XiKeepsTheMomenta) {
  Random random(4);
  const D& Q = p.Q;
  const D P = random.matrix(Q.rows(), Q.cols()), P_0 = Xi(Q, P), k = momentum_k(Q, P);
  EXPECT_LT(testing::costate_defect(Q, P_0), 1e-13);
  EXPECT_LT(largest(momentum_m(Q, P_0) - momentum_m(Q, P)), 1e-13);
  EXPECT_LT(largest(dense_M(Q, P_0) - dense_M(Q, P)), 1e-13);
  EXPECT_LT(largest(P * Q.transpose() - (k + momentum_m(Q, P)) / 2), 1e-13);
  EXPECT_LT(largest(testing::Xi_inverse(Q, P_0, k) - P), 1e-13);
  const D V = random.matrix(3, Q.cols());
  EXPECT_LT(largest(testing::times_M(V, Q, P) - V * dense_M(Q, P)), 1e-12);
}

/// 𝔐, (90)–(92), against its other definition D = ½Q[Λ, U]Qᵀ, and back.
TEST_P(OnFrames, LegendreAndItsInverse) {
  const auto& [lambda, Q, U, Qdot, S, M] = p;
  const D P_0 = Legendre(Q, S);
  const D commutator = lambda.asDiagonal() * U - U * lambda.asDiagonal();
  const D DD = Q * commutator * Q.transpose() / 2;
  EXPECT_LT(largest(P_0 - (S + DD * Q)), 1e-13);
  EXPECT_LT(testing::costate_defect(Q, P_0), 1e-13);
  EXPECT_LT(largest(Legendre_inverse(lambda, Q, P_0) - S), 1e-12);
  EXPECT_LT(
      largest(Legendre_inverse(
                  lambda, Q, testing::Xi_inverse(Q, P_0, D(3 * D::Identity(Q.rows(), Q.rows())))) -
              S),
      1e-12);
}

/// (82), (83), (100), (103): P_0 = QM − ½mQ = QM̄, M̄ = M − ½QᵀmQ = QᵀS̄ − S̄ᵀQ.
TEST_P(OnFrames, TheCostateIsQTimesMBar) {
  const auto& [lambda, Q, U, Qdot, S, M] = p;
  const D P_0 = Legendre(Q, S), m = momentum_m(Q, S);
  EXPECT_LT(largest(m - Q * M * Q.transpose()), 1e-13);
  const D M_bar = M - Q.transpose() * m * Q / 2;
  EXPECT_LT(largest(P_0 - Q * M_bar), 1e-13);
  EXPECT_LT(largest(M_bar - dense_M(Q, S_bar(Q, S))), 1e-13);
  const auto from_M = P_0_of_M(Q, M);
  ASSERT_TRUE(from_M);
  EXPECT_LT(largest(*from_M - P_0), 1e-13);
  if (Q.rows() == Q.cols()) {
    EXPECT_LT(largest(M_bar - M / 2), 1e-13);
  }
}

TEST(OnFramesOutside, AMomentumBesideQIsRefusedWithTheNumber) {
  const Point p(Case{2, 6}, 5);
  Random random(6);
  const D I = D::Identity(6, 6), other = I - p.Q.transpose() * p.Q;
  const D beside = other * random.skew(6) * other;
  const auto refused = P_0_of_M<double>(p.Q, p.M + beside);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().domain, "T*V(n, N)");
  EXPECT_NEAR(refused.error().value, largest(beside), 1e-12);
  EXPECT_NEAR(refused.error().bound, 1e-8 * largest(p.M + beside), 1e-14);
}

TEST(OnFramesWide, KeepsItsDigits) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Point p(Case{2, 7}, seed, 1000);
    const D S = Legendre_inverse(p.lambda, p.Q, Legendre(p.Q, p.S));
    EXPECT_LT(largest(S - p.S), 1e-10 * largest(p.S));
  }
}

/// 10⁶ columns without an N × N matrix, which would take 8 TB.
TEST(OnFramesLarge, NoNByNMatrix) {
  const Point small(Case{2, 5}, 1);
  const Eigen::Index N = 1000000;
  const auto widened = [&](const D& A) {
    D B = D::Zero(A.rows(), N);
    B.leftCols(A.cols()) = A;
    return B;
  };
  Vector<double> lambda = Vector<double>::Ones(N);
  lambda.head(5) = small.lambda;
  const D Q = widened(small.Q), S = widened(small.S), P_0 = Legendre(Q, S);
  EXPECT_LT(largest(Legendre_inverse(lambda, Q, P_0) - S), 1e-12);
  EXPECT_LT(largest(testing::times_M(Q, Q, S) - widened(small.Q * small.M)), 1e-12);
  EXPECT_LT(largest(S_bar(Q, S) - widened(S_bar(small.Q, small.S))), 1e-13);
}

}  // namespace
}  // namespace stiefel
