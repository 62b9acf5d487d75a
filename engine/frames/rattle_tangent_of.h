#pragma once

#include <algorithm>
#include <tuple>
#include <vector>

#include "engine/linalg/iteration/continuation.h"
#include "engine/linalg/matrix_equations/constraint_riccati.h"
#include "engine/methods/support/symmetric_stages.h"
#include "engine/stepping/tangent_map.h"

namespace stiefel {

/// The multiplier Y of a step of RATTLE, in the letters of RattleStiefel.
struct RattleMultiplier {
  using Dense = Eigen::MatrixXd;

  explicit RattleMultiplier(Eigen::Index n)
      : A(n, n), P(n, n), E(n, n), Y(n, n), riccati_(n), found_(n, n) {}

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

/// The tangents of the variational step on V(n, N) by columns. `Columns` has the values of a step
/// of RATTLE, which it makes, and the vectors (δQ, δS), which it moves beside it.
template <class Columns>
class RattleTangentOf final : public TangentMap {
  using Dense = Eigen::MatrixXd;
  using Index = Eigen::Index;

 public:
  RattleTangentOf(const Scene& scene, const ColumnParameters& at)
      : n_(scene.Q().rows()),
        substeps_(scene.substeps()),
        unit_(binary_unit(at.lambda.maxCoeff())),
        h_(at.h / unit_),
        gamma_(symmetric_stages<double>(scene.order() > 0 ? scene.order() : 2)),
        parameters_(at),
        columns_(at.lambda / unit_, n_, scene.arithmetic() == Arithmetic::compensated) {}

  void start(const Dense&, const Dense& V) override {
    columns_.begin(V.cols());
    for (Index v = 0; v < V.cols(); ++v) {
      for (Index j = 0; j < size(); ++j)
        for (Index a = 0; a < n_; ++a)
          columns_.set(v, a, j, V(a + 2 * n_ * j, v), V(a + n_ + 2 * n_ * j, v));
      if (parameters_.by_lambda.col(v).isZero(0) && parameters_.by_h(v) == 0) continue;
      const Eigen::ArrayXd inverse = (parameters_.lambda / unit_).cwiseInverse();
      columns_.vary(v, -(parameters_.by_lambda.col(v).array() / unit_) * inverse * inverse,
                    parameters_.by_h(v) / unit_);
    }
  }

  RunStatus step(const Dense& point) override {
    columns_.set(point);
    const std::size_t stages = 2 * gamma_.size() - 1;
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < stages; ++stage) {
        const double gamma = gamma_[std::min(stage, stages - 1 - stage)];
        if (const RunStatus status = columns_.step(gamma * h_); !status.reached()) return status;
        columns_.move(gamma);
        columns_.swap();
      }
    return {};
  }

  bool direct() const override { return false; }
  RunStatus at(std::int64_t) override { return {Outcome::solver_stalled, std::nullopt}; }

  void read(const Dense&, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v)
      for (Index j = 0; j < size(); ++j)
        for (Index a = 0; a < n_; ++a)
          std::tie(V(a + 2 * n_ * j, v), V(a + n_ + 2 * n_ * j, v)) = columns_.get(v, a, j);
  }

 private:
  Index size() const { return parameters_.lambda.size(); }

  Index n_;
  int substeps_;
  double unit_, h_;  ///< Λ and h are divided by the unit, as in RattleStiefel
  std::vector<double> gamma_;
  ColumnParameters parameters_;
  Columns columns_;
};

}  // namespace stiefel
