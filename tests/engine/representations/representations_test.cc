#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "engine/dense/decompositions.h"
#include "engine/dense/so_3.h"
#include "tests/support/representations/rigid_formulas.h"
#include "tests/support/scenes/random_matrices.h"

namespace stiefel {
namespace {

using testing::largest;
using Random = testing::RandomMatrices<double>;
using D = Matrix<double>;
using Wide = long double;
using W = Matrix<Wide>;
using Svd = Eigen::JacobiSVD<D, Eigen::NoQRPreconditioner>;  // of square matrices

D identity(Eigen::Index N) { return D::Identity(N, N); }

/// A skew M of the operator norm asked for.
D skew_of_norm(Random& random, Eigen::Index N, double norm) {
  const D M = random.skew(N);
  return norm / Svd(M).singularValues()(0) * M;
}

/// Q(A + (I + A²)^{1/2}), A = M/2, in extended precision by the Denman–Beavers iteration.
D symmetric_P(const D& Q, const D& M) {
  const W A = M.cast<Wide>() / 2, one = W::Identity(M.rows(), M.rows());
  W Y = one + A * A, Z = one;
  for (int k = 0; k < 60; ++k) {
    const W Y_next = (Y + Lu<Wide>(Z).solve(one)) / 2;
    Z = ((Z + Lu<Wide>(Y).solve(one)) / 2).eval();
    Y = Y_next;
  }
  return (Q.cast<Wide>() * (A + Y)).cast<double>();
}

TEST(SkewNorm, IsTheLargestSingularValue) {
  for (const int N : {1, 2, 3, 6, 11})
    for (const double scale : {1e-200, 1.0, 1e200}) {
      Random random(static_cast<unsigned>(N));
      const D M = random.skew(N);
      const double expected = scale * Svd(M).singularValues()(0);
      EXPECT_NEAR(skew_norm<double>(scale * M), expected, 1e-14 * expected) << N;
    }
}

TEST(Psi, ReturnsFromItsInverse) {
  for (const int N : {2, 3, 4, 5, 8, 13})
    for (const double norm : {1e-8, 0.5, 1.9, 2 - 1e-6, 2 - 1e-12}) {
      Random random(static_cast<unsigned>(N));
      const D Q = random.frame(N, N), M = skew_of_norm(random, N, norm);
      const auto P = Psi_inverse(Q, M);
      ASSERT_TRUE(P) << N << " " << norm;
      // Up to the edge P is orthogonal and M comes back to rounding ...
      EXPECT_LT(largest(P->transpose() * *P - identity(N)), 4e-15 * N);
      EXPECT_LT(largest(Psi(Q, *P) - M), 4e-15 * N);
      // ... while P itself has an error that grows as the condition says.
      EXPECT_LT(largest(*P - symmetric_P(Q, M)), 2e-15 * N * testing::condition_Psi_inverse(M))
          << norm;
      EXPECT_GT(principal_cosine(Q, *P), 0);
      EXPECT_NEAR(margin_S(Q, *P), 2 - norm, 1e-14);
      EXPECT_NEAR(margin_S_M(M), 2 - norm, 1e-14);
    }
}

/// In three dimensions asinh(μĉ) = asin(μ)ĉ, and the exponential is Rodrigues' formula; [RB] (3.2).
TEST(Psi, IsRodriguesInThreeDimensions) {
  for (const double mu : {0.1, 0.7, 0.999}) {
    Random random(3);
    const D Q = random.frame(3, 3);
    const Eigen::Vector3d c = random.matrix(3, 1).normalized();
    const double angle = std::asin(mu);
    const D R = identity(3) + std::sin(angle) * hat(c) +
                (std::cos(angle) - 1) * (identity(3) - c * c.transpose());
    EXPECT_LT(largest(*Psi_inverse<double>(Q, 2 * mu * hat(c)) - Q * R),
              1e-15 * testing::condition_Psi_inverse<double>(2 * mu * hat(c)));
  }
}

/// The worst relative change of P per change of M, measured in extended precision, is the number
/// stated: 1/(1 − (‖M‖/2)²)^{1/2} in the plane of the largest rotation.
TEST(Psi, HasTheConditionItStates) {
  for (const double margin : {1.0, 1e-2, 1e-6}) {
    W Q = W::Identity(2, 2), M = W::Zero(2, 2), dM = M;
    M(0, 1) = Wide(2 - margin), M(1, 0) = -M(0, 1);
    dM(0, 1) = Wide(1e-5) * Wide(margin), dM(1, 0) = -dM(0, 1);
    const W change = *Psi_inverse<Wide>(Q, M + dM) - *Psi_inverse<Wide>(Q, M);
    const double growth = static_cast<double>(change.norm() / (dM / 2).norm());
    const double stated = testing::condition_Psi_inverse<Wide>(M);
    EXPECT_NEAR(growth / stated, 1, 1e-5) << margin;
  }
}

TEST(Psi, RefusesWithTheNorm) {
  for (const double norm : {2.0, 2.5, 1e6}) {
    Random random(1);
    const D Q = random.frame(4, 4), M = skew_of_norm(random, 4, norm * (1 + 1e-14));
    const auto P = Psi_inverse(Q, M);
    ASSERT_FALSE(P);
    EXPECT_EQ(P.error().domain, "S_M");
    EXPECT_NEAR(P.error().value, norm, 1e-12 * norm);
    EXPECT_EQ(P.error().bound, 2);
    EXPECT_LT(margin_S_M(M), 1e-12);
  }
  D M = D::Constant(3, 3, std::nan(""));
  EXPECT_FALSE(Psi_inverse<double>(identity(3), M));
}

/// S has pairs that Ψ⁻¹ does not return: both P = −Q and P = Q have M = 0.
TEST(Psi, IsOneToOneOnThePrincipalBranchOnly) {
  Random random(5);
  const D Q = random.frame(4, 4), P = -Q;
  EXPECT_EQ(margin_S(Q, P), 2);
  EXPECT_LT(principal_cosine(Q, P), -0.999);
  EXPECT_GT(largest(*Psi_inverse(Q, Psi(Q, P)) - P), 0.5);
}

TEST(Scaling, IsThePowerOfTwoThatMakesTheNormHalfToOne) {
  Random random(7);
  const D Q = random.frame(5, 5);
  for (const double norm : {1e-300, 1e-17, 1e-8, 0.3, 0.999, 1.001, 1.7, 2.1, 63.0, 1e9, 1e150}) {
    const D M = skew_of_norm(random, 5, norm);
    const double epsilon = unit_epsilon(M);
    int exponent;
    EXPECT_EQ(std::frexp(epsilon, &exponent), 0.5);
    EXPECT_LE(epsilon * norm, 1);
    EXPECT_GT(2 * epsilon * norm, 1);
    const auto P = Psi_inverse(Q, M, epsilon);
    ASSERT_TRUE(P);
    EXPECT_LT(largest(Psi(Q, *P, epsilon) - M), 4e-15 / epsilon);
    EXPECT_LT(largest(P->transpose() * *P - identity(5)), 1e-14);
  }
  const D M = 4 * hat(Eigen::Vector3d(0, 0, 1));  // ‖M‖_op a power of two: ε‖M‖_op = 1
  EXPECT_EQ(unit_epsilon(M), 0.25);
  EXPECT_EQ(unit_epsilon<double>(D::Zero(3, 3)), 1);
  EXPECT_EQ(unit_epsilon_of(0x1p-1074), 0x1p1023);
}

}  // namespace
}  // namespace stiefel
