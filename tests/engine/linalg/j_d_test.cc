#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/body/moser_veselov.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/dense/orthogonal.h"
#include "tests/support/linalg/j_d_schur.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/random_scene.h"
#include "tests/support/scenes/rigid_forms.h"
#include "tests/support/scenes/stacked.h"

namespace stiefel {
namespace {

using testing::largest;
using testing::RandomBody;
using MapN = MoserVeselov<SoN<double>>;
using Map3 = MoserVeselov<So3<double, true>>;
using Map4 = MoserVeselov<So4<double, true>>;

/// U of one step from Q = I.
struct Solved {
  RunStatus status;
  Eigen::MatrixXd U, M;
};

Solved solve_n(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h) {
  const Eigen::Index N = lambda.size();
  MapN map(lambda, h);
  auto state = map.start(testing::stacked(Eigen::MatrixXd::Identity(N, N), M));
  const RunStatus status = map.step(state);
  return {status, state.x.value.topRows(N), state.x.value.bottomRows(N)};
}

Solved solve_3(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h) {
  Map3 map(lambda, h);
  Map3::Point x;
  x << 1, 0, 0, 0, vee(M);
  auto state = map.start(x);
  const RunStatus status = map.step(state);
  return {status, rotation_matrix<double>(state.x.value.head<4>()), hat(state.x.value.tail<3>())};
}

/// One step in the coordinates of So4.
Map4::Point coordinates(const Eigen::MatrixXd& Q, const Eigen::MatrixXd& M) {
  Map4::Point x;
  x.head<16>() = Q.reshaped();
  for (int k = 0; k < 6; ++k) x(16 + k) = M(skew4_rows[k], skew4_columns[k]);
  return x;
}

Solved solve_4(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h) {
  Map4 map(lambda, h);
  auto state = map.start(coordinates(Eigen::Matrix4d::Identity(), M));
  const RunStatus status = map.step(state);
  Solved out{status, state.x.value.head<16>().reshaped(4, 4), Eigen::Matrix4d::Zero()};
  for (int k = 0; k < 6; ++k) {
    out.M(skew4_rows[k], skew4_columns[k]) = state.x.value(16 + k);
    out.M(skew4_columns[k], skew4_rows[k]) = -state.x.value(16 + k);
  }
  return out;
}

/// One step by the solver for N dimensions.
Solved solve(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h) {
  if (lambda.size() == 3) return solve_3(lambda, M, h);
  if (lambda.size() == 4) return solve_4(lambda, M, h);
  return solve_n(lambda, M, h);
}

/// UΛ − ΛUᵀ = hM, UᵀU = I and M′ = UᵀMU, for what a step gave.
void expect_solution(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h,
                     const Solved& s, double bound) {
  ASSERT_TRUE(s.status.reached());
  const Eigen::MatrixXd L = lambda.asDiagonal();
  EXPECT_LT(largest(s.U * L - L * s.U.transpose() - h * M), bound * lambda.maxCoeff());
  EXPECT_LT(orthogonality_defect(s.U), bound);
  EXPECT_LT(largest(s.U.transpose() * M * s.U - s.M), bound * largest(M));
}

class JDInverse : public ::testing::TestWithParam<int> {};

TEST_P(JDInverse, AgreesWithTheSchurSolver) {
  const int N = GetParam();
  for (unsigned seed = 1; seed <= 5; ++seed)
    for (const double h : {1e-3, 0.05, 0.2, 0.4, 0.7, -0.3}) {
      const RandomBody body(N, seed);
      const auto U = testing::J_D_inverse_schur(body.lambda, h * body.M);
      const Solved fast = solve_n(body.lambda, body.M, h);
      ASSERT_EQ(U.has_value(), fast.status.reached()) << N << " " << seed << " " << h;
      if (!U) continue;
      expect_solution(body.lambda, body.M, h, fast, 2e-14);
      EXPECT_LT(largest(*U - fast.U), 1e-11);
      if (N != 3 && N != 4) continue;
      const Solved fixed = solve(body.lambda, body.M, h);
      expect_solution(body.lambda, body.M, h, fixed, 4e-15);
      EXPECT_LT(largest(*U - fixed.U), 1e-12);
    }
}
INSTANTIATE_TEST_SUITE_P(Dimensions, JDInverse, ::testing::Values(2, 3, 4, 7, 12));

TEST(JDInverseEdge, LeftDomainNamesTheLargestStep) {
  int left = 0;
  for (const int N : {3, 4, 6})
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const RandomBody body(N, seed);
      const Solved far = solve(body.lambda, body.M, 3);
      if (far.status.reached()) continue;
      ++left;
      ASSERT_EQ(far.status.outcome, Outcome::left_domain);
      const double h = *far.status.largest_step;
      EXPECT_LT(largest(far.M - body.M), 1e-15);  // nothing moved
      const Solved inside = solve(body.lambda, body.M, h);
      expect_solution(body.lambda, body.M, h, inside, 1e-12);
      EXPECT_TRUE(testing::J_D_inverse_schur(body.lambda, 0.999 * h * body.M));
      EXPECT_FALSE(testing::J_D_inverse_schur(body.lambda, 1.0015 * h * body.M))
          << N << " " << seed;
    }
  EXPECT_GE(left, 12);
}

/// Momenta scaled by any factor, equal and unequal λ: no step returns NaN.
TEST(JDInverseEdge, FarBeyondTheLargestStepThereIsNone) {
  for (const int N : {3, 4, 5})
    for (const double spread : {1.0, 4.0, 1e3})
      for (const double factor : {1e1, 1e3, 1e6, 1e27, 1e140}) {
        RandomBody body(N, 3, spread);
        if (spread == 1) body.lambda.setOnes();
        const Solved far = solve(body.lambda, factor * body.M, 1);
        EXPECT_EQ(far.status.outcome, Outcome::left_domain) << N << " " << spread << " " << factor;
        const double h = far.status.largest_step.value_or(0);
        expect_solution(body.lambda, factor * body.M, h, solve(body.lambda, factor * body.M, h),
                        1e-12);
      }
}

TEST(JDInverseEdge, PlatesAndSlightlyNegativeLambda) {
  for (const double least : {0.0, -0.3, 1e-9})
    for (const int N : {3, 4, 5}) {
      RandomBody body(N, 11);
      body.lambda(0) = least;
      for (const double h : {0.01, 0.2, 0.5}) {
        expect_solution(body.lambda, body.M, h, solve_n(body.lambda, body.M, h), 1e-14);
        expect_solution(body.lambda, body.M, h, solve(body.lambda, body.M, h), 1e-14);
      }
    }
}

/// A negative λ: for every |c|, a step that is taken has w_i + w_j in Re > 0, w = spec(UΛ);
/// otherwise it would be on another branch.
TEST(JDInverseEdge, NegativeLambdaTakesNoOtherBranch) {
  int taken = 0;
  for (unsigned seed = 1; seed <= 200; ++seed)
    for (const double h : {0.3, 1.0, 1.5, 2.0, 2.5}) {
      const Eigen::Vector3d lambda(-0.6, 0.9, 1.2), I(2.1, 0.6, 0.3);
      const Eigen::Vector3d omega = vee(RandomBody(3, seed).M).normalized();
      const Solved s = solve_3(lambda, hat(I.cwiseProduct(omega)), h);
      EXPECT_TRUE(s.status.reached() || s.status.outcome == Outcome::left_domain);
      if (!s.status.reached()) continue;
      ++taken;
      const Eigen::Matrix3d W = s.U * lambda.asDiagonal();
      const Eigen::Matrix3d sums = W.trace() * Eigen::Matrix3d::Identity() - W;
      EXPECT_GT(spectrum(sums).real().minCoeff(), -1e-6) << seed << " " << h;
    }
  EXPECT_GT(taken, 300);
}

TEST(JDInverseEdge, WideInertiaKeepsOrthogonality) {
  for (const double spread : {1e3, 1e5})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const RandomBody body(6, seed, spread);
      expect_solution(body.lambda, body.M, 0.1, solve_n(body.lambda, body.M, 0.1), 1e-14);
    }
}

TEST(JDInverseEdge, RestAndTinyMomenta) {
  for (const double scale : {0.0, 1e-200, 1e-30}) {
    const RandomBody body(4, 2);
    for (const auto& by : {solve_n, solve_4}) {
      const Solved s = by(body.lambda, scale * body.M, 0.1);
      ASSERT_TRUE(s.status.reached());
      EXPECT_LE(largest(s.M - scale * body.M), 0.2 * scale);
    }
  }
}

TEST(MoserVeselov, FixedAndDynamicSizeAgree) {
  const RandomBody body(3, 4);
  MapN map_n(body.lambda, 0.1);
  Map3 map_3(body.lambda, 0.1);
  auto state_n = map_n.start(testing::stacked(body.Q, body.M));
  Map3::Point x;
  x << quaternion_of(body.Q), vee(body.M);
  auto state_3 = map_3.start(x);
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(map_n.step(state_n).reached());
    ASSERT_TRUE(map_3.step(state_3).reached());
  }
  const auto Q = rotation_matrix<double>(state_3.x.value.head<4>());
  constexpr double ulps = 64;  // of 1, after 1000 steps: the frame given differs by one
  EXPECT_LT(largest(Q - state_n.x.value.topRows(3)), ulps * 0x1p-52);
  EXPECT_LT(largest(hat(state_3.x.value.tail<3>()) - state_n.x.value.bottomRows(3)),
            ulps * 0x1p-52 * largest(body.M));
}

TEST(MoserVeselov, CoordinatesOfFourDimensionsAgree) {
  const RandomBody body(4, 4);
  MapN map_n(body.lambda, 0.1);
  Map4 map_4(body.lambda, 0.1);
  auto state_n = map_n.start(testing::stacked(body.Q, body.M));
  auto state_4 = map_4.start(coordinates(body.Q, body.M));
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(map_n.step(state_n).reached());
    ASSERT_TRUE(map_4.step(state_4).reached());
  }
  const auto& x = state_n.x.value;
  EXPECT_LT(largest(state_4.x.value - coordinates(x.topRows(4), x.bottomRows(4))), 64 * 0x1p-52);
}

/// S, the symmetric part of U − I, and X = U − I in extended precision, by damped sweeps of
/// S = −½XᵀX with X_ij = (hM_ij + 2λ_i S_ij)/(λ_i + λ_j).
struct ExtendedSolution {
  Matrix<long double> S, X;

  ExtendedSolution(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h)
      : S(Matrix<long double>::Zero(M.rows(), M.rows())), X(S) {
    const Vector<long double> l = lambda.cast<long double>();
    long double change = 1;
    for (int k = 0; k < 1000 && change > 1e-19L; ++k) {
      for (Eigen::Index j = 0; j < X.cols(); ++j)
        for (Eigen::Index i = 0; i < X.rows(); ++i)
          X(i, j) =
              i == j ? S(i, j) : ((long double)h * M(i, j) + 2 * l(i) * S(i, j)) / (l(i) + l(j));
      const Matrix<long double> f = -0.5L * (X.transpose() * X) - S;
      change = f.cwiseAbs().maxCoeff();
      S += 0.6L * f;
    }
    EXPECT_LE(change, 1e-19L);
    Eigen::MatrixXd cosines = S.cast<double>();
    cosines.diagonal().array() += 1;
    EXPECT_TRUE(factor_positive(cosines));  // spec(UΛ) in Re > 0: the principal branch
  }
};

/// The step from Q = I agrees with `exact`: S_ij = h(M′ − M)_ij/2(λ_i − λ_j), in compensated
/// arithmetic with the carry of M′, and U to its rounding. The error of S is that of the residual,
/// 2^-61, times the condition of the equation, which grows as h‖Ω‖ approaches 1.
void expect_exact(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& M, double h,
                  Arithmetic arithmetic, const ExtendedSolution& exact) {
  const Eigen::Index N = lambda.size();
  MapN map(lambda, h, arithmetic);
  auto state = map.start(testing::stacked(Eigen::MatrixXd::Identity(N, N), M));
  ASSERT_TRUE(map.step(state).reached());
  long double U_error = 0, S_error = 0;
  for (Eigen::Index j = 0; j < N; ++j)
    for (Eigen::Index i = 0; i < N; ++i) {
      const long double U = state.x.extended(i, j), sum = (long double)lambda(i) + lambda(j),
                        moved = state.x.extended(N + i, j) - M(i, j),
                        should = 2 * ((long double)lambda(i) - lambda(j)) * exact.S(i, j) / h;
      U_error = std::max(U_error, std::abs(U - (i == j) - exact.X(i, j)));
      S_error = std::max(S_error, std::abs(moved - should) * std::abs(h) / sum);
    }
  const bool compensated = arithmetic == Arithmetic::compensated;
  EXPECT_LT(U_error, compensated ? 0x1p-53L : 0x1p-51L);
  EXPECT_LT(S_error, !compensated ? 0x1p-51L : h > 0.5 ? 0x1p-56L : 0x1p-60L);
}

/// Sizes that are no multiple of a tile, and λ = 0 with the same Ω.
TEST(JDInverseWide, StepsAreExactToRounding) {
  for (const int N : {5, 16, 33, 64})
    for (const double spread : {1e2, 1e4, 1e6})
      for (const double h : {-0.1, 0.5, 0.9}) {
        SCOPED_TRACE(::testing::Message() << N << " 1:" << spread << " h = " << h);
        RandomBody body(N, 5, spread);
        if (N == 33) {
          const Eigen::MatrixXd Omega = inverse_inertia<double>(body.lambda, body.M);
          body.lambda(7) = 0;
          body.M = body.lambda.asDiagonal() * Omega + Omega * body.lambda.asDiagonal();
        }
        const ExtendedSolution exact(body.lambda, body.M, h);
        for (const Arithmetic arithmetic : {Arithmetic::compensated, Arithmetic::plain})
          expect_exact(body.lambda, body.M, h, arithmetic, exact);
      }
}

TEST(JDInverseWide, StepsOfAVeryLargeBodyAreExactToRounding) {
  const RandomBody body(256, 5, 1e4);
  for (const double h : {0.1, 0.5})
    expect_exact(body.lambda, body.M, h, Arithmetic::compensated,
                 ExtendedSolution(body.lambda, body.M, h));
}

/// Momenta of equal size, so that the parts of Ω differ by the spread of Λ: each element of M keeps
/// its digits, and with it the energy.
TEST(JDInverseWide, InvariantsStayOverManySteps) {
  constexpr int N = 24, steps = 400;
  for (const double spread : {1e2, 1e4, 1e6})
    for (const double h_omega : {0.1, 0.5}) {
      const RandomBody body(N, 7, spread), drawn(N, 8);
      Eigen::MatrixXd M = drawn.M, Omega = M;
      inverse_inertia(body.lambda, M, Omega);
      M *= h_omega / testing::operator_norm(Omega);
      MapN map(body.lambda, 1);
      auto state = map.start(testing::stacked(body.Q, M));
      const auto energy = [&] {
        long double E = 0;
        for (int j = 0; j < N; ++j)
          for (int i = 0; i < j; ++i) {
            const long double m = state.x.extended(N + i, j);
            E += m * m / ((long double)body.lambda(i) + body.lambda(j)) / 2;
          }
        return E;
      };
      const long double E = energy();
      for (int k = 0; k < steps; ++k) ASSERT_TRUE(map.step(state).reached());
      const Eigen::MatrixXd Q = state.x.value.topRows(N), now = state.x.value.bottomRows(N);
      EXPECT_LT(std::abs(energy() / E - 1), 1e-16L) << spread << " " << h_omega;
      EXPECT_LT(orthogonality_defect(Q), 1e-14) << spread << " " << h_omega;
      EXPECT_LT(largest(Q * now * Q.transpose() - body.Q * M * body.Q.transpose()),
                1e-14 * testing::operator_norm(M))
          << spread << " " << h_omega;
    }
}

/// A map without a history of its own goes on from a state with the same bits.
TEST(JDInverseWide, TheStateAloneDecidesTheNextStep) {
  const RandomBody body(20, 2, 1e3);
  MapN map(body.lambda, 0.3);
  auto state = map.start(testing::stacked(body.Q, body.M));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(map.step(state).reached());
  auto copy = state;
  ASSERT_TRUE(map.step(state).reached());
  ASSERT_TRUE(MapN(body.lambda, 0.3).step(copy).reached());
  EXPECT_EQ(state.x.value, copy.x.value);
  EXPECT_EQ(state.x.carry, copy.x.carry);
}

/// Near and beyond the largest step, the solver for wide Λ hands over to Newton's method: it finds
/// U, or the status names the largest step.
TEST(JDInverseWide, EveryStepIsSolvedOrTypedAsImpossible) {
  for (const double spread : {1e2, 1e4}) {
    RandomBody body(20, 3, spread);
    int left = 0;
    for (const double h : {0.7, 0.85, 0.95, 1.0, 1.1, 1.5, 3.0, 30.0}) {
      const Solved s = solve_n(body.lambda, body.M, h);
      if (s.status.reached()) {
        expect_solution(body.lambda, body.M, h, s, 1e-12);
        continue;
      }
      ++left;
      ASSERT_EQ(s.status.outcome, Outcome::left_domain) << h;
      EXPECT_LT(*s.status.largest_step, h);
      EXPECT_GT(*s.status.largest_step, 0.9);
      EXPECT_EQ(s.M, body.M);  // nothing moved
    }
    EXPECT_GT(left, 0);
    body.M(3, 2) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(solve_n(body.lambda, body.M, 0.1).status.outcome, Outcome::not_finite);
  }
}

}  // namespace
}  // namespace stiefel
