#include <gtest/gtest.h>

#include "engine/body/discrete_pairs.h"
#include "engine/frame/stiefel_momenta.h"
#include "engine/structure/symplectic_defect.h"
#include "engine/structure/tangent_spaces.h"
#include "tests/support/linalg/j_d_inverse.h"
#include "tests/support/scenes/random_matrices.h"

namespace stiefel {
namespace {

/// Derivatives by differences of eighth order in extended precision: errors near 1e-16.
using Wide = long double;
using W = Matrix<Wide>;
using Random = testing::RandomMatrices<Wide>;
using testing::stacked;

constexpr double tolerance = 1e-13;

/// max |ω'(Tφu, Tφv) − factor·ω(u, v)| over pairs of unit tangent vectors.
template <class Source, class Target, class Map>
double defect(const Source& source, const Target& target, Map&& phi, const W& x, Wide factor) {
  Random random(99);
  double worst = 0;
  for (int k = 0; k < 4; ++k) {
    const auto unit_tangent = [&] {
      const W u = source.tangent(x, random.matrix(x.rows(), x.cols()));
      return W(u / u.norm());
    };
    const W u = unit_tangent(), v = unit_tangent();
    const auto wrapped = [&](const W& y) { return std::optional<W>(phi(y)); };
    const W Tu = *derivative<Wide>(wrapped, x, u), Tv = *derivative<Wide>(wrapped, x, v);
    const Wide before = factor * source.form(x, u, v);
    EXPECT_GT(std::abs(before), 1e-6L);  // a form that is 0 would pass the comparison
    worst = std::max(worst, static_cast<double>(std::abs(target.form(phi(x), Tu, Tv) - before)));
  }
  return worst;
}

/// The maps of [RB] §7 on stacked pairs, all of one Λ and h = 1.
struct Discrete {
  Vector<Wide> lambda;
  Eigen::Index N;
  W Q, U, Q_next;

  explicit Discrete(int size) : N(size) {
    Random random(static_cast<unsigned>(size));
    lambda = random.lambda(N, 2);
    Q = random.frame(N, N);
    const W K = random.skew(N);
    U = testing::J_D_inverse<Wide>(lambda, K * (0.8L / skew_norm(K)));
    Q_next = Q * U;
  }
  W top(const W& x) const { return x.topRows(N); }
  W bottom(const W& x) const { return x.bottomRows(N); }

  W Sigma_H(const W& x) const { return stacked(top(x), Psi(top(x), bottom(x))); }
  W Sigma_L_(const W& x) const { return stacked(bottom(x), Sigma_L(lambda, top(x), bottom(x))); }
  W psi_(const W& x) const { return stacked(bottom(x), *psi(lambda, top(x), bottom(x))); }
  W Phi(const W& x) const {  // (MDRBn)
    const W step = testing::J_D_inverse<Wide>(lambda, bottom(x));
    return stacked(top(x) * step, step.transpose() * bottom(x) * step);
  }
  W phi_H(const W& x) const {  // (7.1)
    return x * testing::J_D_inverse<Wide>(lambda, Psi(top(x), bottom(x)));
  }
  W phi_L(const W& x) const {  // (7.2)
    const W M = Sigma_L(lambda, top(x), bottom(x));
    return stacked(bottom(x), bottom(x) * testing::J_D_inverse<Wide>(lambda, M));
  }
};

class Forms : public ::testing::TestWithParam<int> {
 protected:
  const Discrete d{GetParam()};
  const W pair = stacked(d.Q, d.Q_next);  // (Q_{k−1}, Q_k)
  const W QM = d.Sigma_L_(pair), QP = d.psi_(pair);
  const CotangentOfRotations<Wide> omega{};
  const PairsOfRotations<Wide> gl{Vector<Wide>::Ones(GetParam())}, L{d.lambda};
};
INSTANTIATE_TEST_SUITE_P(Dimensions, Forms, ::testing::Values(2, 3, 4));

TEST_P(Forms, PsiPullsOmegaBackToTwiceOmegaGl) {  // (3.11), Σ_H
  EXPECT_LT(defect(
                gl, omega, [&](const W& x) { return d.Sigma_H(x); }, QP, 2),
            tolerance);
  // and Ψ⁻¹ does the reverse
  const auto inverse = [&](const W& x) {
    return stacked(d.top(x), *Psi_inverse<Wide>(d.top(x), d.bottom(x)));
  };
  EXPECT_LT(defect(omega, gl, inverse, QM, 0.5L), tolerance);
}
TEST_P(Forms, SigmaL) {  // (7.12)
  EXPECT_LT(defect(
                L, omega, [&](const W& x) { return d.Sigma_L_(x); }, pair, 2),
            tolerance);
}
TEST_P(Forms, LittlePsi) {
  EXPECT_LT(defect(
                L, gl, [&](const W& x) { return d.psi_(x); }, pair, 1),
            tolerance);
}
TEST_P(Forms, ThePairMapIsSymplectic) {
  EXPECT_LT(defect(
                L, L, [&](const W& x) { return d.phi_L(x); }, pair, 1),
            tolerance);
}
TEST_P(Forms, TheSymmetricMapIsSymplectic) {
  EXPECT_LT(defect(
                gl, gl, [&](const W& x) { return d.phi_H(x); }, QP, 1),
            tolerance);
}
TEST_P(Forms, TheMoserVeselovMapIsSymplectic) {
  EXPECT_LT(defect(
                omega, omega, [&](const W& x) { return d.Phi(x); }, QM, 1),
            tolerance);
}

// ---- frames ----

struct FramesCase {
  int n, N;
};
class FrameForms : public ::testing::TestWithParam<FramesCase> {
 protected:
  void SetUp() override {
    const auto [n_, N] = GetParam();
    n = n_;
    Random random(7);
    lambda = random.lambda(N);
    Q = random.frame(n, N);
    S = S_of_Qdot<Wide>(lambda, Q * random.skew(N));
  }
  Eigen::Index n;
  Vector<Wide> lambda;
  W Q, S;
};
INSTANTIATE_TEST_SUITE_P(Sizes, FrameForms,
                         ::testing::Values(FramesCase{1, 3}, FramesCase{2, 4}, FramesCase{3, 5},
                                           FramesCase{3, 3}));

TEST_P(FrameForms, TangentVectorsKeepTheConstraints) {
  Random random(8);
  const W x = stacked(Q, S), G = random.matrix(2 * n, Q.cols());
  const auto curve = [&](const W& u) {  // the change of the constraints along u
    const W A = u.topRows(n), B = u.bottomRows(n);
    const W inverse = lambda.cwiseInverse().asDiagonal();
    return std::array<W, 3>{A * Q.transpose(),
                            B * inverse * Q.transpose() + A * inverse * S.transpose(),
                            B * Q.transpose() + A * S.transpose()};
  };
  const auto symmetric = [](const W& R) {
    return static_cast<double>((R + R.transpose()).cwiseAbs().maxCoeff());
  };
  const auto on_S = curve(CotangentOfFrames<Wide>{lambda}.tangent(x, G));
  EXPECT_LT(symmetric(on_S[0]), 1e-16);
  EXPECT_LT(symmetric(on_S[1]), 1e-16);
  const auto on_W = curve(CostatesOfFrames<Wide>().tangent(x, G));
  EXPECT_LT(symmetric(on_W[0]), 1e-16);
  EXPECT_LT(symmetric(on_W[2]), 1e-16);
}

/// 𝔐, and Ξ between leaves W^k, keep (63).
TEST_P(FrameForms, LegendreIsSymplectic) {
  const CotangentOfFrames<Wide> cotangent{lambda};
  const CostatesOfFrames<Wide> costates;
  const auto M = [&](const W& x) {
    return stacked(x.topRows(n), Legendre<Wide>(x.topRows(n), x.bottomRows(n)));
  };
  const auto M_inverse = [&](const W& x) {
    return stacked(x.topRows(n), Legendre_inverse<Wide>(lambda, x.topRows(n), x.bottomRows(n)));
  };
  EXPECT_LT(defect(cotangent, costates, M, stacked(Q, S), 1), tolerance);
  EXPECT_LT(defect(costates, cotangent, M_inverse, M(stacked(Q, S)), 1), tolerance);
  EXPECT_LT(defect(costates, costates, M, stacked(Q, S + 0.3L * Q), 1), tolerance);
}

/// Theorem 5: (Q, P_0) ↦ (Q, QM̄) takes (71) on W⁰ to (93), Z = ∂M̄ by differentiation of (100).
TEST_P(FrameForms, TheoremFive) {
  const CostatesOfFrames<Wide> costates;
  const W P_0 = Legendre(Q, S), x = stacked(Q, P_0);
  const auto M_bar = [&](const W& y) -> std::optional<W> {
    const W A = y.topRows(n), B = y.bottomRows(n);
    return W(dense_M(A, B) - A.transpose() * momentum_m(A, B) * A / 2);
  };
  Random random(9);
  for (int k = 0; k < 4; ++k) {
    const auto lifted = [&](const W& u) {
      return stacked(u.topRows(n), Q * *derivative<Wide>(M_bar, x, u));
    };
    const W u = costates.tangent(x, random.matrix(2 * n, Q.cols()));
    const W v = costates.tangent(x, random.matrix(2 * n, Q.cols()));
    const W factors = stacked(Q, S_bar(Q, S));
    const Wide first = omega_cotangent<Wide>(factors, lifted(u), lifted(v));
    EXPECT_NEAR(static_cast<double>(first), static_cast<double>(omega_pairs(u, v)), tolerance);
    EXPECT_GT(std::abs(first), 1e-4L);
  }
}

/// At n = N the form (63) on (Q, S) is ω on (Q, M): both are −d of ⟨S, dQ⟩ = ½ tr(MᵀQᵀdQ).
TEST(FrameForms, AreTheRigidBodysAtFullRank) {
  Random random(10);
  const Vector<Wide> lambda = random.lambda(4);
  const W Q = random.frame(4, 4), S = S_of_Qdot<Wide>(lambda, Q * random.skew(4));
  const auto momentum = [&](const W& x) {
    return stacked(x.topRows(4), dense_M<Wide>(x.topRows(4), x.bottomRows(4)));
  };
  EXPECT_LT(defect(CotangentOfFrames<Wide>{lambda}, CotangentOfRotations<Wide>(), momentum,
                   stacked(Q, S), 1),
            tolerance);
}

}  // namespace
}  // namespace stiefel
