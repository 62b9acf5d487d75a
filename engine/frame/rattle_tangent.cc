#include <algorithm>

#include "engine/dense/continuation.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/symmetric_solve.h"
#include "engine/frame/rattle_tangent.h"
#include "engine/frame/rattle_tangent_pass.h"
#include "engine/methods/symmetric_stages.h"
#include "stiefel/stop.h"

namespace stiefel {

RattleTangentPass::~RattleTangentPass() = default;

namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;
using Tiles = std::vector<TileRow>;

/// Returns element (a, j) of a matrix of n rows.
auto& element(auto& x, Index n, Index a, Index j) {
  return x[static_cast<std::size_t>(j / TileRow::columns * n + a)].x[j % TileRow::columns];
}

/// The multiplier Y of a step of RATTLE, in the letters of RattleStiefel.
struct RattleMultiplier {
  explicit RattleMultiplier(Index n) : A(n, n), P(n, n), E(n, n), Y(n, n), riccati_(n) {}

  /// Finds Y for a step of size h from the present Y, else along the branch from Y = 0.
  /// `measure(t)` sets A = GDᵀ, P = GGᵀ and E = DDᵀ for a step of size t.
  bool find(double h, auto&& measure) {
    const auto solve = [&](double t) {
      measure(t);
      E.diagonal().array() -= 1;
      return riccati_.solve(A, P, E, Y);
    };
    if (solve(h)) return true;
    Y.setZero();
    return !(continuation(1, [&](double t) {
               found_ = Y;
               if (solve(t * h)) return true;
               Y = found_;
               return false;
             }) < 1);
  }

  Dense A, P, E, Y;

 private:
  ConstraintRiccati<double> riccati_;
  Dense found_;
};

/// Moves vectors (δQ, δS) by the steps of RATTLE on V(n, N), one by one, in passes over packs of
/// columns. With B and Z for Y/h and Y′/h in the letters of RattleStiefel, a step is
///
///     S_½ = S + BQ,   Q′ = Q + hS_½Λ⁻¹,   S′ = S_½ + ZQ′,   C = QΛ⁻¹Q′ᵀ,   K′ = Q′Λ⁻¹Q′ᵀ,
///
/// and with w = δS + BδQ its derivative
///
///     δQ′ = δQ + h(w + δB Q)Λ⁻¹ + hS_½δΛ⁻¹ + δh S_½Λ⁻¹,     δQ′Q′ᵀ + Q′δQ′ᵀ = 0,
///     δS′ = w + δB Q + ZδQ′ + δZ Q′,                        (δQ′V′ᵀ + Q′δV′ᵀ) + (…)ᵀ = 0,
///
/// V′ = S′Λ⁻¹: linear equations for the symmetric δB and δZ, with C and K′.
class RattleTangent final : public TangentMap {
 public:
  RattleTangent(const Scene& scene, const TangentParameters& at)
      : n_(scene.Q().rows()),
        N_(at.lambda.size()),
        substeps_(scene.substeps()),
        compensated_(scene.arithmetic() == Arithmetic::compensated),
        unit_(binary_unit(at.lambda.maxCoeff())),
        gamma_(symmetric_stages<double>(scene.order() > 0 ? scene.order() : 2)),
        parameters_(at),
        pass_(make_rattle_tangent_pass(n_)),
        multiplier_(n_),
        C_(n_),
        K_(n_),
        B_(n_, n_),
        Z_(n_, n_),
        R_(n_, n_),
        X_(n_, n_) {
    inverse_ = zero(1);
    for (Index j = 0; j < N_; ++j) element(inverse_, 1, 0, j) = 1 / (at.lambda(j) / unit_);
    Q_ = S_ = half_ = next_ = end_ = G1_ = V1_ = work_ = zero(n_);
  }

  void start(const Dense&, const Dense& V) override {
    vectors_.assign(static_cast<std::size_t>(V.cols()), {zero(n_), zero(n_), {}, {}, {}, 0});
    Z_.setZero();
    for (Index v = 0; v < V.cols(); ++v) {
      Vector& x = vectors_[static_cast<std::size_t>(v)];
      take(V.col(v).reshaped(2 * n_, N_), x.Q, x.S);
      if (compensated_) x.Q_carry = x.S_carry = zero(n_);
      if (parameters_.constant(v)) continue;
      x.by_inverse = zero(1);
      for (Index j = 0; j < N_; ++j) {
        const double inverse = element(inverse_, 1, 0, j);
        element(x.by_inverse, 1, 0, j) = -(parameters_.by_lambda(j, v) / unit_) * inverse * inverse;
      }
      x.by_h = parameters_.by_h(v) / unit_;
    }
  }

  RunStatus step(const Dense& point) override {
    take(point, Q_, S_);
    const std::size_t stages = 2 * gamma_.size() - 1;
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < stages; ++stage) {
        const double gamma = gamma_[std::min(stage, stages - 1 - stage)];
        if (const RunStatus status = find_step(gamma * parameters_.h / unit_); !status.reached())
          return status;
        for (Vector& x : vectors_) move(x, gamma * x.by_h);
        Q_.swap(next_);
        S_.swap(end_);
      }
    return {};
  }

  void read(const Dense&, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v) {
      const Vector& x = vectors_[static_cast<std::size_t>(v)];
      auto block = V.col(v).reshaped(2 * n_, N_);
      for (Index j = 0; j < N_; ++j)
        for (Index a = 0; a < n_; ++a) {
          block(a, j) = element(x.Q, n_, a, j);
          block(n_ + a, j) = element(x.S, n_, a, j);
        }
    }
  }

 private:
  struct Vector {
    Tiles Q, S, Q_carry, S_carry;
    Tiles by_inverse;  ///< empty where the parameters are constant
    double by_h;
  };

  Tiles zero(Index rows) const {
    const Index tiles = (N_ + TileRow::columns - 1) / TileRow::columns;
    return Tiles(static_cast<std::size_t>(tiles * rows), TileRow{});
  }
  void take(const auto& blocks, Tiles& Q, Tiles& S) const {
    for (Index j = 0; j < N_; ++j)
      for (Index a = 0; a < n_; ++a) {
        element(Q, n_, a, j) = blocks(a, j);
        element(S, n_, a, j) = blocks(n_ + a, j);
      }
  }
  RattleColumns columns() {
    return {N_,           inverse_.data(), Q_.data(),  S_.data(), half_.data(),
            next_.data(), end_.data(),     G1_.data(), V1_.data()};
  }

  /// Finds the values of a step from Q and S.
  RunStatus find_step(double h) {
    stop_point(12 * static_cast<double>(n_ * n_ * N_));
    h_ = h;
    auto &A = multiplier_.A, &P = multiplier_.P, &E = multiplier_.E, &Y = multiplier_.Y;
    Y = h_ * Z_;
    const RattleColumns x = columns();
    if (!multiplier_.find(h_,
                          [&](double t) { pass_->measure(x, t, A.data(), P.data(), E.data()); }))
      return {Outcome::solver_stalled, std::nullopt};
    B_ = Y / h_;
    C_.factor(A + P * Y);
    pass_->advance(x, h_, B_.data(), A.data(), E.data());
    K_.factor(A);
    K_.solve(-1, E, Z_);
    pass_->finish(x, Z_.data());
    return {};
  }

  void move(Vector& x, double by_h) {
    stop_point(9 * static_cast<double>(n_ * n_ * N_));
    const RattleColumns at = columns();
    const RattleVector vector{x.Q.data(),
                              x.S.data(),
                              compensated_ ? x.Q_carry.data() : nullptr,
                              compensated_ ? x.S_carry.data() : nullptr,
                              x.by_inverse.empty() ? nullptr : x.by_inverse.data(),
                              by_h,
                              work_.data()};
    pass_->begin(at, vector, h_, B_.data(), R_.data());
    C_.solve(-1 / h_, R_, X_);
    pass_->move_Q(at, vector, h_, X_.data(), Z_.data(), R_.data());
    K_.solve(-1, R_, X_);
    pass_->move_S(at, vector, X_.data());
  }

  Index n_, N_;
  int substeps_;
  bool compensated_;
  double unit_;  ///< Λ and h are divided by it, as in RattleStiefel
  double h_ = 0;
  std::vector<double> gamma_;
  TangentParameters parameters_;
  std::unique_ptr<RattleTangentPass> pass_;
  RattleMultiplier multiplier_;
  SymmetricSolve C_, K_;
  Dense B_, Z_, R_, X_;
  Tiles inverse_, Q_, S_, half_, next_, end_, G1_, V1_, work_;
  std::vector<Vector> vectors_;
};

}  // namespace

std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const TangentParameters& at) {
  return std::make_unique<RattleTangent>(scene, at);
}

}  // namespace stiefel
