#include <gtest/gtest.h>

#include <random>

#include "engine/dense/continuation.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/history.h"
#include "engine/dense/orthogonal.h"
#include "engine/dense/so_3.h"
#include "engine/dense/so_n.h"
#include "engine/numbers/compensated.h"
#include "engine/numbers/split_product.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"

namespace stiefel {
namespace {

using testing::largest;
using testing::RandomBody;

/// A state in both spaces.
struct BothSpaces {
  So3<double, true>::State q;
  SoN<double>::State X;
  explicit BothSpaces(const RandomBody& body) : X(6, 3) {
    q << quaternion_of(body.Q), vee(body.M);
    X << body.Q, body.M;
  }
};

TEST(So3, AgreesWithSoN) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const RandomBody body(3, seed);
    const BothSpaces at(body);
    SoN<double> space_n(3);
    Eigen::Vector3d omega, other = Eigen::Vector3d(0.3, -0.2, 0.5) * seed / 10, bracket;
    Eigen::MatrixXd Omega(3, 3), Bracket(3, 3);
    So3<double, true>::inverse_inertia(body.lambda, at.q, omega);
    SoN<double>::InverseInertia(body.lambda)(at.X, Omega);
    EXPECT_LT(largest(hat(omega) - Omega), 1e-15);

    So3<double, true>::bracket(omega, other, bracket);
    SoN<double>::bracket(Omega, hat(other), Bracket);
    EXPECT_LT(largest(hat(bracket) - Bracket), 1e-15);

    So3<double, true>::State dq;
    SoN<double>::State dX(6, 3);
    So3<double, true>().displacement(at.q, other, dq);
    space_n.displacement(at.X, hat(other), dX);
    const Eigen::Vector4d moved = (at.q + dq).head<4>();
    EXPECT_LT(largest(rotation_matrix<double>(moved) - (at.X + dX).topRows(3)), 2e-15);
    EXPECT_LT(largest(hat((at.q + dq).tail<3>()) - (at.X + dX).bottomRows(3)), 1e-14);
  }
}

TEST(So3, QuaternionOfEveryBranch) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const Eigen::Matrix3d Q = RandomBody(3, seed).Q;
    EXPECT_LT(largest(rotation_matrix<double>(quaternion_of(Q)) - Q), 2e-15);
  }
  for (const Eigen::Vector3d& d : {Eigen::Vector3d(1, -1, -1), {-1, 1, -1}, {-1, -1, 1}}) {
    const Eigen::Matrix3d Q = d.asDiagonal();
    EXPECT_EQ(rotation_matrix<double>(quaternion_of(Q)), Q);
  }
}

TEST(Exponential, OfASkewMatrixAgreesWithItsSeriesAndIsOrthogonal) {
  for (const double size : {1e-12, 1e-3, 0.4, 0.9, 3.0, 8.0})
    for (const int N : {2, 3, 5, 9}) {
      const Eigen::MatrixXd M = RandomBody(N, 7).M;
      const Eigen::MatrixXd Theta = M * (size / M.cwiseAbs().colwise().sum().maxCoeff());
      Eigen::MatrixXd D(N, N);
      Exponential<double> exponential(N, MatrixKind::skew);
      exponential(Theta, D);
      Matrix<long double> term = Matrix<long double>::Identity(N, N);
      Matrix<long double> series = Matrix<long double>::Zero(N, N);
      for (int k = 1; k < 120; ++k) {
        term = (term * Theta.cast<long double>() / k).eval();
        series += term;
      }
      EXPECT_LT(largest((D.cast<long double>() - series).cast<double>()),
                4e-15 * std::max(size, 1e-30) * std::max(1.0, size))
          << N << " " << size;
      EXPECT_LT(orthogonality_defect(D + Eigen::MatrixXd::Identity(N, N)),
                1e-14 * std::max(1., size));
    }
}

TEST(Lyapunov, SolvesItsEquation) {
  for (const int N : {1, 2, 5, 12}) {
    const RandomBody body(std::max(N, 2), 3);
    Eigen::MatrixXd A = (body.M + Eigen::MatrixXd(body.lambda.asDiagonal())).topLeftCorner(N, N);
    const Eigen::MatrixXd G = body.Q.topLeftCorner(N, N);
    Lyapunov<double> lyapunov(N);
    Eigen::MatrixXd Y(N, N);
    lyapunov.factor(A);
    lyapunov.solve(G, Y);
    EXPECT_LT(largest(A.transpose() * Y + Y * A - G), 1e-13);
  }
}

/// Of N = 60 the iteration makes several pieces.
TEST(Lyapunov, SolvesItsEquationInPieces) {
  struct Looks final : Turn {
    void pass() override { ++count; }
    int count = 0;
  } looks;
  const std::stop_token never;
  const StopScope scope(never, looks);
  const Eigen::MatrixXd A =
      Eigen::MatrixXd::Random(60, 60) + 60 * Eigen::MatrixXd::Identity(60, 60);
  const Eigen::MatrixXd G = Eigen::MatrixXd::Random(60, 60);
  Lyapunov<double> lyapunov(60);
  Eigen::MatrixXd Y(60, 60);
  lyapunov.factor(A);
  EXPECT_GT(looks.count, 5);
  lyapunov.solve(G, Y);
  EXPECT_LT(largest(A.transpose() * Y + Y * A - G), 1e-13);
  EXPECT_NEAR(lyapunov.smallest_real_part(), spectrum(A).real().minCoeff(), 1e-11);
}

TEST(Decompositions, OfASkewMatrixAreUnitary) {
  for (const int N : {0, 1, 2, 3, 8, 41}) {
    const Eigen::MatrixXd R = Eigen::MatrixXd::Random(N, N), A = 1e200 * (R - R.transpose());
    const auto [w, X, Y] = skew_eigen(A);
    const Eigen::MatrixXcd Z = X + std::complex<double>(0, 1) * Y,
                           iA = std::complex<double>(0, 1) * A,
                           I = Eigen::MatrixXcd::Identity(N, N);
    ASSERT_EQ(w.size(), N);
    if (N == 0) continue;
    EXPECT_LT((Z.adjoint() * Z - I).cwiseAbs().maxCoeff(), 1e-14 * (N + 3)) << N;
    EXPECT_LT((iA * Z - Z * w.asDiagonal()).cwiseAbs().maxCoeff(), 2e185 * (N + 3)) << N;
    EXPECT_LT(largest(w - skew_eigenvalues(A)), 2e185 * (N + 3)) << N;
  }
}

TEST(Decompositions, RefuseWhatIsNotPositive) {
  for (const int size : {1, 40, 300})
    for (const int at : {0, size / 2, size - 1}) {
      const Eigen::MatrixXd R = Eigen::MatrixXd::Random(size, size);
      Eigen::MatrixXd A = R * R.transpose() + Eigen::MatrixXd::Identity(size, size);
      A(at, at) = -1;
      EXPECT_FALSE(factor_positive(A)) << size << " " << at;
    }
}

TEST(SplitProduct, IsExactFarBelowRounding) {
  std::mt19937_64 generator(5);
  const auto uniform = [&] { return 2 * std::generate_canonical<double, 53>(generator) - 1; };
  for (const int N : {3, 8, 40}) {
    Eigen::MatrixXd X(N, N), epsilon(N, N), high(N, N), low(N, N);
    for (double& x : X.reshaped()) x = uniform();
    for (double& x : epsilon.reshaped()) x = 0x1p-54 * uniform();
    SplitProduct product(N);
    product(X, epsilon, high, low);
    const Matrix<long double> exact_X = X.cast<long double>() + epsilon.cast<long double>();
    const Matrix<long double> exact = exact_X.transpose() * exact_X;
    double worst = 0;
    for (int j = 0; j < N; ++j)
      for (int i = 0; i <= j; ++i) {
        const long double sum = (static_cast<long double>(low(i, j)) + low(j, i)) + high(i, j);
        worst = std::max(worst, static_cast<double>(std::abs(sum - exact(i, j))));
      }
    EXPECT_LT(worst, N * 0x1p-62) << N;  // the comparison itself is no better
  }
}

TEST(Accumulator, CompensatedLosesNothingPlainDoes) {
  using Block = Eigen::Vector2d;
  Accumulator<Block> careful(Block(1, 1), Arithmetic::compensated);
  Accumulator<Block> plain(Block(1, 1), Arithmetic::plain);
  for (int k = 0; k < 1'000'000; ++k) {
    careful.add_scalar(0, 0, 0x1p-54);
    careful.add(1, 0, 0x1p-60L);
    plain.add_scalar(0, 0, 0x1p-54);
  }
  EXPECT_EQ(careful.value(0), 1 + 1e6 * 0x1p-54);
  EXPECT_EQ(careful.value(1) + careful.carry(1), 1 + 1e6 * 0x1p-60);
  EXPECT_EQ(plain.value(0), 1);
}

TEST(History, ExtrapolatesCubicsExactly) {
  History<double, 4> history(1, 1);
  Eigen::MatrixXd next(1, 1), value(1, 1);
  EXPECT_FALSE(history.predict(next));
  const auto cubic = [](double t) { return 3 - 2 * t + 5 * t * t - t * t * t; };
  for (int k = 0; k < 6; ++k) {
    value(0, 0) = cubic(k);
    history.push(value);
  }
  ASSERT_TRUE(history.predict(next));
  EXPECT_DOUBLE_EQ(next(0, 0), cubic(6));
}

/// 9 smooth values give the accuracy of 8 points; from noise nothing is predicted.
TEST(History, TakesAsManyPointsAsHelp) {
  History<double, 8> smooth(1, 1), noise(1, 1);
  Eigen::MatrixXd next(1, 1), value(1, 1);
  for (int k = 0; k < 9; ++k) {
    value(0, 0) = std::cos(0.2 * k);
    smooth.push(value);
    value(0, 0) = k % 2 == 0 ? 1 : -1;
    noise.push(value);
  }
  ASSERT_TRUE(smooth.predict(next));
  EXPECT_NEAR(next(0, 0), std::cos(0.2 * 9), 1e-5);
  EXPECT_FALSE(noise.predict(next));
}

TEST(FollowBranch, FindsTheEndToOnePerMille) {
  for (const double end : {1e-5, 0.01, 0.3337, 0.99}) {
    const double found = continuation(1, [&](double t) { return t <= end; });
    EXPECT_LE(found, end);
    EXPECT_GE(found, end * (1 - 1e-3));
  }
  const auto with_gap = [](double t) { return t < 0.4 || t > 0.45; };
  EXPECT_EQ(continuation(1, with_gap), 1);
  EXPECT_NEAR(continuation(1, with_gap, 0.04), 0.4, 0.4e-3);
  EXPECT_EQ(continuation(1, [](double) { return true; }), 1);
  EXPECT_EQ(continuation(1, [](double) { return false; }), 0);
  const auto until = [](double end) { return [end](double t) { return t <= end; }; };
  EXPECT_NEAR(continuation(1, until(0.7), 1, 0.5, 0.1), 0.7, 0.1 * 0.7);
  EXPECT_EQ(continuation(1, until(0.5), 1, 0.5, 0.1), 0.5);
}

/// Eigen splits the sums of a product where a panel of the factors fills the first cache: with 32
/// KiB after 504 numbers, with 48 KiB after 760. States have the same bits on both kinds of
/// processor only if the sizes are fixed.
TEST(ProductBlocking, DoesNotDependOnTheProcessorsCaches) {
  EXPECT_EQ(Eigen::l1CacheSize(), 32 << 10);
  EXPECT_EQ(Eigen::l2CacheSize(), 256 << 10);
  EXPECT_EQ(Eigen::l3CacheSize(), 2 << 20);
}

}  // namespace
}  // namespace stiefel
