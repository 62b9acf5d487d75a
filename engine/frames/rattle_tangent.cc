#include "engine/frames/rattle_tangent.h"

#include "engine/frames/rattle_tangent_of.h"
#include "engine/frames/symmetric_solve.h"
#include "engine/methods/variational.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// The values of steps, in the letters of RattleStiefel; B and Z are Y/h and Y′/h:
///
///     S_½ = S + BQ,   Q′ = Q + hS_½Λ⁻¹,   S′ = S_½ + ZQ′,   C = GQ′ᵀ,   K′ = Q′Λ⁻¹Q′ᵀ.
class RattleValues {
 public:
  RattleValues(const Eigen::VectorXd& lambda, Index n)
      : inverse(lambda.cwiseInverse()),
        Q(n, lambda.size()),
        S(Q),
        half(Q),
        next(Q),
        end(Q),
        G1(Q),
        V1(Q),
        B(n, n),
        Z(n, n),
        C(n),
        K(n),
        n_(n),
        G_(Q),
        D_(Q),
        multiplier_(n),
        half_B_(Dense::Zero(n, n)),
        upper_(SymmetricSolve::size(n)) {}

  /// Forgets the last step.
  void restart() { half_B_.setZero(); }

  /// Makes a step from Q and S.
  RunStatus step(double size) {
    stop_point(12 * static_cast<double>(n_ * Q.size()));
    h = size;
    auto &A = multiplier_.A, &P = multiplier_.P, &E = multiplier_.E, &Y = multiplier_.Y;
    G_.noalias() = Q * inverse.asDiagonal();
    P.noalias() = G_ * G_.transpose();
    Y = (h * h) * half_B_;
    const bool found = multiplier_.find(h, [&](double t) {
      D_.noalias() = S * inverse.asDiagonal();
      D_ = Q + t * D_;
      A.noalias() = G_ * D_.transpose();
      E.noalias() = D_ * D_.transpose();
    });
    if (!found) return {Outcome::solver_stalled, std::nullopt};
    B = Y / h;
    half.noalias() = B * Q;
    half += S;
    V1.noalias() = half * inverse.asDiagonal();
    next = Q + h * V1;
    G1.noalias() = next * inverse.asDiagonal();
    A.noalias() = G_ * next.transpose();
    C.factor(A);
    A.noalias() = G1 * next.transpose();
    K.factor(A);
    E.noalias() = next * V1.transpose();
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a <= b; ++a) upper_[SymmetricSolve::at(a, b)] = -(E(a, b) + E(b, a));
    K.solve(upper_.data());
    for (Index b = 0; b < n_; ++b)
      for (Index a = 0; a < n_; ++a) Z(a, b) = upper_[SymmetricSolve::at(a, b)][0];
    half_B_ = Z / h;
    end.noalias() = Z * next;
    end += half;
    V1.noalias() = end * inverse.asDiagonal();
    return {};
  }

  Eigen::VectorXd inverse;  ///< Λ⁻¹
  double h = 0;
  Dense Q, S, half, next, end;  ///< Q, S, S_½, Q′, S′
  Dense G1, V1;                 ///< Q′Λ⁻¹, S′Λ⁻¹
  Dense B, Z;
  SymmetricSolve C, K;

 private:
  Index n_;
  Dense G_, D_;
  RattleMultiplier multiplier_;
  Dense half_B_;  ///< Z/h of the last step, from which the next solve starts
  std::vector<Pair> upper_;
};

/// Two tangent vectors (δQ, δS), and δΛ⁻¹ and δh along them.
struct RattlePair {
  RattlePair(Index size, bool compensated)
      : Q(static_cast<std::size_t>(size), compensated),
        S(static_cast<std::size_t>(size), compensated) {}

  PairSums Q, S;
  std::vector<Pair> by_inverse;  ///< empty where the parameters are constant
  Pair by_h = 0;
};

/// Moves two vectors by one step. With w = δS + BδQ,
///
///     δQ′ = δQ + h(w + δB Q)Λ⁻¹ + hS_½δΛ⁻¹ + δh S_½Λ⁻¹,     δQ′Q′ᵀ + Q′δQ′ᵀ = 0,
///     δS′ = w + δB Q + ZδQ′ + δZ Q′,                        (δQ′V′ᵀ + Q′δV′ᵀ) + (…)ᵀ = 0,
///
/// V′ = S′Λ⁻¹: linear equations for the symmetric δB and δZ. `work` has the size of a vector.
template <Index n>
void move(const RattleValues& at, RattlePair& x, Pair by_h, Pair* work) {
  const Index N = at.Q.cols();
  const bool varies = !x.by_inverse.empty();
  const Pair h = at.h;
  Pair R[n * n] = {}, B[SymmetricSolve::at(n - 1, n - 1) + 1];
  const auto shift = [&](Index j, Index a) {
    const double half = at.half(a, j);
    return h * Pair(half) * x.by_inverse[static_cast<std::size_t>(j)] +
           by_h * Pair(half * at.inverse(j));
  };
  for (Index j = 0; j < N; ++j) {
    const Pair* const dQ = x.Q.values() + n * j;
    const Pair* const dS = x.S.values() + n * j;
    Pair* const w = work + n * j;
    const Pair hL = at.h * at.inverse(j);
    for (Index a = 0; a < n; ++a) {
      Pair sum = Pair(at.B(a, 0)) * dQ[0];
      for (Index b = 1; b < n; ++b) sum += Pair(at.B(a, b)) * dQ[b];
      w[a] = sum;
      Pair W = dQ[a] + hL * (dS[a] + sum);
      if (varies) W += shift(j, a);
      for (Index b = 0; b < n; ++b) R[a + n * b] += W * Pair(at.next(b, j));
    }
  }
  const double by_step = -1 / at.h;
  for (Index b = 0; b < n; ++b)
    for (Index a = 0; a <= b; ++a)
      B[SymmetricSolve::at(a, b)] = Pair(by_step) * (R[a + n * b] + R[b + n * a]);
  at.C.solve(B);
  for (Pair& r : R) r = 0;
  for (Index j = 0; j < N; ++j) {
    const Pair* const dQ = x.Q.values() + n * j;
    const Pair* const dS = x.S.values() + n * j;
    Pair* const w = work + n * j;
    const Pair hL = at.h * at.inverse(j);
    for (Index a = 0; a < n; ++a) {
      Pair sum = w[a];
      for (Index b = 0; b < n; ++b) sum += B[SymmetricSolve::at(a, b)] * Pair(at.Q(b, j));
      w[a] = sum;
      Pair step = hL * (dS[a] + sum);
      if (varies) step += shift(j, a);
      x.Q.add(static_cast<std::size_t>(n * j + a), step);
    }
    for (Index a = 0; a < n; ++a) {
      Pair sum = w[a];
      for (Index b = 0; b < n; ++b) sum += Pair(at.Z(a, b)) * dQ[b];
      w[a] = sum;
      const Pair half = dS[a] + sum;
      for (Index b = 0; b < n; ++b)
        R[a + n * b] += dQ[a] * Pair(at.V1(b, j)) + half * Pair(at.G1(b, j));
      if (!varies) continue;
      const Pair dV = x.by_inverse[static_cast<std::size_t>(j)] * Pair(at.end(a, j));
      for (Index b = 0; b < n; ++b) R[a + n * b] += dV * Pair(at.next(b, j));
    }
  }
  for (Index b = 0; b < n; ++b)
    for (Index a = 0; a <= b; ++a) B[SymmetricSolve::at(a, b)] = -(R[a + n * b] + R[b + n * a]);
  at.K.solve(B);
  for (Index j = 0; j < N; ++j)
    for (Index a = 0; a < n; ++a) {
      Pair sum = work[n * j + a];
      for (Index b = 0; b < n; ++b) sum += B[SymmetricSolve::at(a, b)] * Pair(at.next(b, j));
      x.S.add(static_cast<std::size_t>(n * j + a), sum);
    }
}

using Move = void (*)(const RattleValues&, RattlePair&, Pair, Pair*);
constexpr Move moves[] = {move<1>, move<2>, move<3>, move<4>, move<5>, move<6>};

/// The vectors in pairs, beside the values of a step.
class RattlePairs {
 public:
  RattlePairs(const Eigen::VectorXd& lambda, Index n, bool compensated)
      : n_(n),
        compensated_(compensated),
        move_(moves[n - 1]),
        values_(lambda, n),
        work_(static_cast<std::size_t>(values_.Q.size())) {}

  void begin(Index vectors) {
    pairs_.assign(static_cast<std::size_t>((vectors + 1) / 2), {values_.Q.size(), compensated_});
    values_.restart();
  }
  void set(Index v, Index a, Index j, double dQ, double dS) {
    RattlePair& x = pairs_[static_cast<std::size_t>(v / 2)];
    const auto i = static_cast<std::size_t>(a + n_ * j);
    x.Q.set(i, v % 2, dQ);
    x.S.set(i, v % 2, dS);
  }
  std::pair<double, double> get(Index v, Index a, Index j) const {
    const RattlePair& x = pairs_[static_cast<std::size_t>(v / 2)];
    return {x.Q.values()[a + n_ * j][v % 2], x.S.values()[a + n_ * j][v % 2]};
  }
  void vary(Index v, const Eigen::ArrayXd& by_inverse, double by_h) {
    RattlePair& x = pairs_[static_cast<std::size_t>(v / 2)];
    x.by_inverse.resize(static_cast<std::size_t>(by_inverse.size()), 0.0);
    for (Index j = 0; j < by_inverse.size(); ++j)
      x.by_inverse[static_cast<std::size_t>(j)].set(v % 2, by_inverse(j));
    x.by_h.set(v % 2, by_h);
  }

  void set(const Dense& point) {
    values_.Q = point.topRows(n_);
    values_.S = point.bottomRows(n_);
  }
  RunStatus step(double size) { return values_.step(size); }
  void move(double gamma) {
    for (RattlePair& x : pairs_) {
      stop_point(18 * static_cast<double>(n_ * values_.Q.size()));
      move_(values_, x, Pair(gamma) * x.by_h, work_.data());
    }
  }
  void swap() {
    std::swap(values_.Q, values_.next);
    std::swap(values_.S, values_.end);
  }

 private:
  Index n_;
  bool compensated_;
  Move move_;
  RattleValues values_;
  std::vector<RattlePair> pairs_;
  std::vector<Pair> work_;
};

}  // namespace

bool has_rattle_tangent(const Scene& scene) {
  return scene.method() == Variational::traits.name && scene.Q().rows() <= Index(std::size(moves));
}

std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const ColumnParameters& at) {
  constexpr Index wide = 64;
  return scene.dimension() < wide ? std::make_unique<RattleTangentOf<RattlePairs>>(scene, at)
                                  : wide_rattle_tangent(scene, at);
}

}  // namespace stiefel
