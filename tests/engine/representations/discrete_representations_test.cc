#include <gtest/gtest.h>

#include "engine/body/discrete_pairs.h"
#include "engine/dense/decompositions.h"
#include "engine/structure/dirac_bracket.h"
#include "tests/support/linalg/j_d_inverse.h"
#include "tests/support/scenes/random_matrices.h"

namespace stiefel {
namespace {

using testing::largest;
using D = Matrix<double>;
using Random = testing::RandomMatrices<double>;

D identity(Eigen::Index N) { return D::Identity(N, N); }

D of_norm(const D& M, double norm) { return norm / skew_norm(M) * M; }

/// Q_{k−1}, Q_k, Q_{k+1} on a trajectory of (MDRBn), by the test's own J_D⁻¹.
struct Triple {
  Vector<double> lambda;
  D before, Q, after, M, U;
  Triple(int N, unsigned seed, double norm = 1.2) {
    Random random(seed);
    lambda = random.lambda(N, 2);
    before = random.frame(N, N);
    const D M_before = of_norm(random.skew(N), norm);
    const D U_before = testing::J_D_inverse<double>(lambda, M_before);
    Q = before * U_before;
    M = U_before.transpose() * M_before * U_before;
    U = testing::J_D_inverse<double>(lambda, M);
    after = Q * U;
  }
};

class Pairs : public ::testing::TestWithParam<int> {
 protected:
  const int N = GetParam();
  const Triple t{N, 21};
};
INSTANTIATE_TEST_SUITE_P(Dimensions, Pairs, ::testing::Values(2, 3, 4, 6));

TEST_P(Pairs, JDAndItsInverse) {
  EXPECT_LT(largest(J_D(t.lambda, t.U) - t.M), 1e-14);
  const auto U = J_D_inverse(t.lambda, t.M);
  ASSERT_TRUE(U);
  EXPECT_LT(largest(*U - t.U), 1e-13);
}

TEST_P(Pairs, SigmaLIsTheMomentumAfterTheStep) {
  EXPECT_LT(largest(Sigma_L(t.lambda, t.before, t.Q) - t.M), 1e-14);
  const double h = 0.1;  // physical momentum
  EXPECT_LT(largest(Sigma_L(t.lambda, t.before, t.Q, h) - t.M / h), 1e-13);
  const auto before = Sigma_L_inverse(t.lambda, t.Q, D(t.M / h), h);
  ASSERT_TRUE(before);
  EXPECT_LT(largest(*before - t.before), 1e-13);
}

TEST_P(Pairs, PsiOfThePairAndTheInterpolations) {
  const auto& [lambda, before, Q, after, M, U] = t;
  const auto P = psi(lambda, before, Q);
  ASSERT_TRUE(P);
  EXPECT_LT(largest(P->transpose() * *P - identity(N)), 1e-14);
  EXPECT_LT(largest(Psi(Q, *P) - M), 1e-14);
  const D Lambda = lambda.asDiagonal(), Omega = Q.transpose() * before;

  const D Sigma = weight_behind(lambda, before, Q, *P);
  EXPECT_LT(largest(Sigma - Sigma.transpose()), 1e-14);
  EXPECT_LT(largest(Sigma * Sigma - Lambda * Omega.transpose() * Sigma - Sigma * Omega * Lambda +
                    Lambda * Lambda - identity(N)),
            1e-13);

  const D L = weight_ahead(lambda, Q, *P, after);
  EXPECT_LT(largest(L - L.transpose()), 1e-13);
  const D corrected = L * L + Lambda * U.transpose() * L + L * U * Lambda + Lambda * Lambda;
  EXPECT_LT(largest(corrected - identity(N)), 1e-13);
  const D printed = L * L + Lambda * U * L + L * U * Lambda + Lambda * Lambda;
  EXPECT_GT(largest(printed - identity(N)), 1e-2);  // (7.19) as printed does not hold
  // (7.18), (6.17): tr Λ_k = tr exp(asinh(M/2)) − tr ΛU
  EXPECT_NEAR(L.trace(), exp_asinh<double>(M / 2)->trace() - (Lambda * U).trace(), 1e-13);
}

/// W ↦ ΛWU + UᵀWΛ on so(N) ([RB] §7, Ω̄ = Uᵀ), written out: its determinant is ∏(w_i + w_j).
TEST_P(Pairs, ELIsDecidedByTheSumsOfEigenvalues) {
  const D W = t.U * t.lambda.asDiagonal(), Lambda = t.lambda.asDiagonal();
  std::vector<D> basis;
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < j; ++i) {
      D E = D::Zero(N, N);
      E(i, j) = 1, E(j, i) = -1;
      basis.push_back(E);
    }
  const auto size = static_cast<Eigen::Index>(basis.size());
  D matrix(size, size);
  for (Eigen::Index a = 0; a < size; ++a) {
    const D& E = basis[static_cast<std::size_t>(a)];
    const D image = Lambda * E * t.U + t.U.transpose() * E * Lambda;
    for (Eigen::Index b = 0; b < size; ++b)
      matrix(b, a) = trace_product(basis[static_cast<std::size_t>(b)], image) / 2;
  }
  const Eigen::VectorXcd w =
      W.eigenvalues();  // of real Schur forms; the margin is from complex ones
  std::complex<double> product = 1;
  double least = 1e300;
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < j; ++i) {
      product *= w(i) + w(j);
      least = std::min(least, std::abs(w(i) + w(j)));
    }
  EXPECT_NEAR(determinant(matrix) / product.real(), 1, 1e-11);
  EXPECT_NEAR(margin_E_L(t.lambda, t.U), least, 1e-12);
  EXPECT_GT(least, 0.1);
}

TEST(PairsOutside, SLRefusesWithTheNorm) {
  Random random(31);
  const Vector<double> lambda = Vector<double>::Constant(3, 1.5);
  D c = random.skew(3);
  c = of_norm(c, 1);
  const double angle = 1.2;  // Λ = λI: J_D(exp(aĉ)) = 2λ sin a ĉ
  const D U = identity(3) + std::sin(angle) * c + (1 - std::cos(angle)) * c * c;
  const D Q = random.frame(3, 3), next = Q * U;
  const double norm = 3 * std::sin(angle);
  EXPECT_NEAR(margin_D_L(lambda, U), 2 - norm, 1e-14);
  EXPECT_NEAR(margin_S_L(lambda, Q, next), 2 - norm, 1e-14);
  const auto no_P = psi(lambda, Q, next);
  ASSERT_FALSE(no_P);
  EXPECT_EQ(no_P.error().domain, "S_L");
  EXPECT_NEAR(no_P.error().value, norm, 1e-13);
  EXPECT_EQ(no_P.error().bound, 2);
  // J_D⁻¹ itself exists up to 2λ = 3 on this ray.
  const auto refused = J_D_inverse(lambda, D(4 * c));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().domain, "J_D(SO(N))");
  EXPECT_NEAR(refused.error().value, 4, 1e-13);
  EXPECT_NEAR(refused.error().bound, 3, 1e-2);
  EXPECT_FALSE(Sigma_L_inverse(lambda, Q, D(4 * c)));
}

/// Ω_L degenerates where two eigenvalues of UΛ sum to 0: U a half turn.
TEST(PairsOutside, ELEndsAtAHalfTurn) {
  const Vector<double> lambda = Vector<double>::LinSpaced(3, 1, 1);
  const D U = Eigen::Vector3d(1, -1, -1).asDiagonal();
  EXPECT_NEAR(margin_E_L(lambda, U), 0, 1e-14);
}

// ---- the Dirac bracket ----

PairFactors random_function(Random& random, Eigen::Index N, int factors) {
  PairFactors F;
  for (int k = 0; k < factors; ++k) F.factors.push_back({random.matrix(N, N), random.matrix(N, N)});
  return F;
}

/// The bracket of Ω_gl|S from its definition: in a basis of tangent vectors, {F, K} = dFᵀ W⁻¹ dK
/// with Ω(X_F, ·) = dF and {F, K} = Ω(X_F, X_K).
double bracket_of_form(const D& Q, const D& P, const PairFactors& F, const PairFactors& K) {
  const Eigen::Index N = Q.cols();
  std::vector<D> basis;
  for (int j = 0; j < N; ++j)
    for (int i = 0; i < j; ++i) {
      D E = D::Zero(N, N);
      E(i, j) = 1, E(j, i) = -1;
      basis.push_back(testing::stacked(Q * E, D::Zero(N, N)));
      basis.push_back(testing::stacked(D::Zero(N, N), P * E));
    }
  const auto size = static_cast<Eigen::Index>(basis.size());
  D form(size, size);
  Vector<double> dF(size), dK(size);
  const auto f = jet_of(F, Q, P), k = jet_of(K, Q, P);
  const auto along = [&](const Jet& jet, const D& u) {
    return (trace_product(jet.by_Q, u.topRows(N)) + trace_product(jet.by_P, u.bottomRows(N))) / 2;
  };
  for (Eigen::Index a = 0; a < size; ++a) {
    const D& u = basis[static_cast<std::size_t>(a)];
    dF(a) = along(f, u), dK(a) = along(k, u);
    for (Eigen::Index b = 0; b < size; ++b)
      form(a, b) = omega_pairs(u, basis[static_cast<std::size_t>(b)]) / 2;
  }
  const Eigen::PartialPivLU<D> lu(form.transpose());
  const Vector<double> X_F = lu.solve(dF), X_K = lu.solve(dK);
  return X_F.dot(form * X_K);
}

TEST(DiracBracket, EqualsTheBracketOfOmegaGl) {
  for (const int N : {2, 3, 5})
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Random random(seed);
      const D Q = random.frame(N, N), P = *Psi_inverse(Q, of_norm(random.skew(N), 1.6));
      for (const auto& [first, second] : {std::pair(1, 1), std::pair(2, 1), std::pair(2, 2)}) {
        const PairFactors F = random_function(random, N, first);
        const PairFactors K = random_function(random, N, second);
        const double bracket = dirac_bracket(Q, P, F, K), expected = bracket_of_form(Q, P, F, K);
        EXPECT_NEAR(bracket, expected, 1e-11 * (1 + std::abs(expected))) << N << " " << seed;
        EXPECT_NEAR(dirac_bracket(Q, P, K, F), -bracket, 1e-11 * (1 + std::abs(bracket)));
      }
    }
}

/// A function of the constraint QQᵀ alone is a Casimir: its bracket with anything is 0.
TEST(DiracBracket, ConstraintsAreCasimirs) {
  Random random(3);
  const int N = 3;
  const D Q = random.frame(N, N), P = *Psi_inverse(Q, of_norm(random.skew(N), 1.0));
  const PairFactors K = random_function(random, N, 2);
  double bracket = 0;  // of (QQᵀ)_01 = Σ_j Q_0j Q_1j
  for (int j = 0; j < N; ++j) {
    PairFactors F;
    for (const int i : {0, 1}) {
      F.factors.push_back({D::Zero(N, N), D::Zero(N, N)});
      F.factors.back().first(i, j) = 1;
    }
    bracket += dirac_bracket(Q, P, F, K);
  }
  EXPECT_NEAR(bracket, 0, 1e-12);
}

}  // namespace
}  // namespace stiefel
