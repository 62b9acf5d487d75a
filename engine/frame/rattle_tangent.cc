#include <algorithm>

#include "engine/frame/rattle_stiefel.h"
#include "engine/frame/stiefel_maps.h"
#include "engine/methods/symmetric_stages.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// Moves vectors (δQ, δS) by the steps of RATTLE on V(n, N), one by one. With B and Z for Y/h and
/// Y′/h in the letters of RattleStiefel, a step is
///
///     S_½ = S + BQ,   Q′ = Q + hS_½Λ⁻¹,   S′ = S_½ + ZQ′,   C = QΛ⁻¹Q′ᵀ,   K′ = Q′Λ⁻¹Q′ᵀ,
///
/// and with w = δS + BδQ and s = hS_½δΛ⁻¹ + δh S_½Λ⁻¹ its derivative
///
///     δQ′ = δQ + h(w + δB Q)Λ⁻¹ + s,     δQ′Q′ᵀ + Q′δQ′ᵀ = 0,
///     δS′ = w + δB Q + ZδQ′ + δZ Q′,     (δQ′V′ᵀ + Q′δV′ᵀ) + (…)ᵀ = 0,   V′ = S′Λ⁻¹:
///
/// linear equations for the symmetric δB and δZ, δB C + CᵀδB = −(WQ′ᵀ + Q′Wᵀ)/h, W = δQ + hwΛ⁻¹ +
/// s, and the same for δZ with K′.
class RattleTangent final : public TangentMap {
 public:
  RattleTangent(const Scene& scene, const TangentParameters& at)
      : n_(scene.Q().rows()),
        substeps_(scene.substeps()),
        arithmetic_(scene.arithmetic()),
        unit_(binary_unit(at.lambda.maxCoeff())),
        inverse_((at.lambda / unit_).cwiseInverse()),
        gamma_(symmetric_stages<double>(scene.order() > 0 ? scene.order() : 2)),
        parameters_(at),
        map_(at.lambda, n_, at.h, Arithmetic::plain),
        state_(map_.start(Dense::Zero(2 * n_, at.lambda.size()))),
        C_(n_),
        K_(n_) {}

  void start(const Dense&, const Dense& V) override {
    state_.half_B.setZero();
    vectors_.clear();
    for (Index v = 0; v < V.cols(); ++v) {
      const auto x = V.col(v).reshaped(2 * n_, inverse_.size());
      const Eigen::VectorXd by_inverse =
          -(parameters_.by_lambda.col(v) / unit_).cwiseProduct(inverse_.cwiseAbs2());
      vectors_.push_back({{x.topRows(n_), arithmetic_},
                          {x.bottomRows(n_), arithmetic_},
                          by_inverse,
                          parameters_.by_h(v) / unit_});
    }
  }

  RunStatus step(const Dense& point) override {
    map_.restart(state_, point);
    const std::size_t stages = 2 * gamma_.size() - 1;
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < stages; ++stage) {
        const double gamma = gamma_[std::min(stage, stages - 1 - stage)];
        const double h = gamma * parameters_.h;
        stop_point(work());
        if (!map_.find_multipliers(state_, h).reached())
          return {Outcome::solver_stalled, std::nullopt};
        const Step at(state_.x.value, map_, inverse_, h / unit_);
        C_.factor(at.Q * at.G1.transpose());
        K_.factor(map_.K1());
        for (Vector& x : vectors_) move(x, at, gamma * x.by_h);
        map_.advance(state_, h);
      }
    return {};
  }

  void read(const Dense&, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v) {
      auto x = V.col(v).reshaped(2 * n_, inverse_.size());
      x.topRows(n_) = vectors_[static_cast<std::size_t>(v)].Q.value;
      x.bottomRows(n_) = vectors_[static_cast<std::size_t>(v)].S.value;
    }
  }

 private:
  /// A step of RATTLE; Λ and h are divided by the unit of RattleStiefel.
  struct Step {
    double h;
    Dense Q, half, next, end, G1, V1;  ///< Q, S_½, Q′, S′, Q′Λ⁻¹, S′Λ⁻¹

    Step(const Dense& x, const RattleStiefel<double>& map, const Eigen::VectorXd& inverse,
         double h_)
        : h(h_), Q(x.topRows(x.rows() / 2)) {
      half = x.bottomRows(Q.rows()) + map.B() * Q;
      next = Q + h * half * inverse.asDiagonal();
      end = half + map.Z() * next;
      G1 = next * inverse.asDiagonal();
      V1 = end * inverse.asDiagonal();
    }
  };
  struct Vector {
    Accumulator<Dense> Q, S;
    Eigen::VectorXd by_inverse;
    double by_h;
  };

  double work() const { return 12 * static_cast<double>(n_ * n_ * inverse_.size()); }

  void move(Vector& x, const Step& at, double by_h) {
    stop_point(work());
    const bool varies = by_h != 0 || !x.by_inverse.isZero(0);
    if (varies) shift_ = at.half * (at.h * x.by_inverse + by_h * inverse_).asDiagonal();
    kick_.noalias() = map_.B().lazyProduct(x.Q.value);
    change_ = at.h * (x.S.value + kick_) * inverse_.asDiagonal();
    if (varies) change_ += shift_;
    change_ += x.Q.value;  // W
    R_.noalias() = change_ * at.next.transpose() / -at.h;
    kick_.noalias() += symmetric_by(C_).lazyProduct(at.Q);
    change_ = at.h * (x.S.value + kick_) * inverse_.asDiagonal();
    if (varies) change_ += shift_;
    x.Q.add(change_);
    kick_.noalias() += map_.Z().lazyProduct(x.Q.value);
    change_ = x.S.value + kick_;
    R_.noalias() = -x.Q.value * at.V1.transpose();
    R_.noalias() -= change_ * at.G1.transpose();
    if (varies) R_ -= at.end * x.by_inverse.asDiagonal() * at.next.transpose();
    kick_.noalias() += symmetric_by(K_).lazyProduct(at.next);
    x.S.add(kick_);
  }

  /// Returns the symmetric X with XC + CᵀX = R + Rᵀ.
  const Dense& symmetric_by(auto& C) {
    X_ = R_ + R_.transpose();
    C.solve(X_, X_);
    return X_;
  }

  Index n_;
  int substeps_;
  Arithmetic arithmetic_;
  double unit_;
  Eigen::VectorXd inverse_;  ///< Λ⁻¹
  std::vector<double> gamma_;
  TangentParameters parameters_;
  RattleStiefel<double> map_;
  RattleStiefel<double>::State state_;
  Lyapunov<double> C_;
  SymmetricLyapunov<double> K_;
  std::vector<Vector> vectors_;
  Dense shift_, kick_, change_, R_, X_;  ///< workspace of `move`
};

}  // namespace

std::unique_ptr<TangentMap> rattle_tangent(const Scene& scene, const TangentParameters& at) {
  return std::make_unique<RattleTangent>(scene, at);
}

}  // namespace stiefel
