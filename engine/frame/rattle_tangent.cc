#include <algorithm>

#include "engine/dense/symmetric_solve.h"
#include "engine/frame/rattle_stiefel.h"
#include "engine/frame/rattle_tangent_pass.h"
#include "engine/frame/stiefel_maps.h"
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
        map_(at.lambda, n_, at.h, Arithmetic::plain),
        state_(map_.start(Dense::Zero(2 * n_, N_))),
        pass_(make_rattle_tangent_pass(n_)),
        C_(n_),
        K_(n_),
        R_(n_, n_),
        X_(n_, n_) {
    inverse_ = zero(1);
    for (Index j = 0; j < N_; ++j) element(inverse_, 1, 0, j) = 1 / (at.lambda(j) / unit_);
    Q_ = S_ = half_ = next_ = end_ = G1_ = V1_ = work_ = zero(n_);
  }

  void start(const Dense&, const Dense& V) override {
    state_.half_B.setZero();
    vectors_.assign(static_cast<std::size_t>(V.cols()), {zero(n_), zero(n_), {}, {}, {}, 0});
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
    map_.restart(state_, point);
    take(point, Q_, S_);
    const std::size_t stages = 2 * gamma_.size() - 1;
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < stages; ++stage) {
        const double gamma = gamma_[std::min(stage, stages - 1 - stage)];
        const double h = gamma * parameters_.h / unit_;
        stop_point(12 * static_cast<double>(n_ * n_ * N_));
        if (!map_.find_multipliers(state_, gamma * parameters_.h).reached())
          return {Outcome::solver_stalled, std::nullopt};
        const auto& at = state_.moments;
        R_ = at.QQ[1] + h * at.QV[1];
        R_.noalias() += h * at.QQ[2] * map_.B();
        C_.factor(R_);
        K_.factor(map_.K1());
        pass_->step(columns(), h, map_.B().data(), map_.Z().data());
        for (Vector& x : vectors_) move(x, h, gamma * x.by_h);
        const bool last = k + 1 == substeps_ && stage + 1 == stages;
        if (!last) map_.advance(state_, gamma * parameters_.h);
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
    constexpr Index width = TileRow::columns;
    for (Index first = 0; first < N_; first += width)
      for (Index a = 0; a < n_; ++a) {
        double *q = &element(Q, n_, a, first), *s = &element(S, n_, a, first);
        for (Index j = 0; j < std::min(width, N_ - first); ++j) {
          q[j] = blocks(a, first + j);
          s[j] = blocks(n_ + a, first + j);
        }
      }
  }
  RattleColumns columns() {
    return {N_,           inverse_.data(), Q_.data(),  S_.data(), half_.data(),
            next_.data(), end_.data(),     G1_.data(), V1_.data()};
  }

  void move(Vector& x, double h, double by_h) {
    stop_point(9 * static_cast<double>(n_ * n_ * N_));
    const RattleColumns at = columns();
    const RattleVector vector{x.Q.data(),
                              x.S.data(),
                              compensated_ ? x.Q_carry.data() : nullptr,
                              compensated_ ? x.S_carry.data() : nullptr,
                              x.by_inverse.empty() ? nullptr : x.by_inverse.data(),
                              by_h,
                              work_.data()};
    pass_->begin(at, vector, h, map_.B().data(), R_.data());
    C_.solve(-1 / h, R_, X_);
    pass_->move_Q(at, vector, h, X_.data(), map_.Z().data(), R_.data());
    K_.solve(-1, R_, X_);
    pass_->move_S(at, vector, X_.data());
  }

  Index n_, N_;
  int substeps_;
  bool compensated_;
  double unit_;  ///< Λ and h are divided by it, as in RattleStiefel
  std::vector<double> gamma_;
  TangentParameters parameters_;
  RattleStiefel<double> map_;
  RattleStiefel<double>::State state_;
  std::unique_ptr<RattleTangentPass> pass_;
  SymmetricSolve C_, K_;
  Dense R_, X_;
  Tiles inverse_, Q_, S_, half_, next_, end_, G1_, V1_, work_;
  std::vector<Vector> vectors_;
};

}  // namespace

std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const TangentParameters& at) {
  return std::make_unique<RattleTangent>(scene, at);
}

}  // namespace stiefel
