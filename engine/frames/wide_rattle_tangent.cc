#include <algorithm>
#include <optional>

#include "engine/frames/passes/rattle_tangent_pass.h"
#include "engine/frames/rattle_tangent.h"
#include "engine/frames/symmetric_solve.h"
#include "engine/linalg/iteration/continuation.h"
#include "engine/linalg/matrix_equations/constraint_riccati.h"
#include "engine/methods/support/symmetric_stages.h"
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

/// The values of a step of RATTLE, in the letters of RattleTangent.
class WideRattleValues {
 public:
  WideRattleValues(const Eigen::VectorXd& lambda, Index n)
      : C(n),
        K(n),
        B(n, n),
        Z(Dense::Zero(n, n)),
        n_(n),
        N_(lambda.size()),
        pass_(make_rattle_tangent_pass(n)),
        riccati_(n),
        A_(n, n),
        P_(n, n),
        E_(n, n),
        Y_(n, n),
        found_(n, n) {
    inverse_ = zero(1);
    for (Index j = 0; j < N_; ++j) element(inverse_, 1, 0, j) = 1 / lambda(j);
    Q_ = S_ = half_ = next_ = end_ = G1_ = V1_ = zero(n);
  }

  Tiles zero(Index rows) const {
    const Index tiles = (N_ + TileRow::columns - 1) / TileRow::columns;
    return Tiles(static_cast<std::size_t>(tiles * rows), TileRow{});
  }
  double inverse(Index j) { return element(inverse_, 1, 0, j); }
  RattleTangentPass& pass() const { return *pass_; }

  /// Forgets the last step.
  void restart() { Z.setZero(); }
  void set(const Dense& point) {
    for (Index j = 0; j < N_; ++j)
      for (Index a = 0; a < n_; ++a) {
        element(Q_, n_, a, j) = point(a, j);
        element(S_, n_, a, j) = point(n_ + a, j);
      }
  }

  /// Makes a step from Q and S.
  RunStatus step(double size) {
    stop_point(12 * static_cast<double>(n_ * n_ * N_));
    h = size;
    Y_ = h * Z;
    if (!solve(h) && !follow()) return {Outcome::solver_stalled, std::nullopt};
    B = Y_ / h;
    C.factor(A_ + P_ * Y_);
    const RattleColumns x = columns();
    pass_->advance(x, h, B.data(), A_.data(), E_.data());
    K.factor(A_);
    K.solve(-1, E_.data(), Z.data());
    pass_->finish(x, Z.data());
    return {};
  }
  /// Goes on from the end of the step.
  void swap() {
    Q_.swap(next_);
    S_.swap(end_);
  }

  RattleColumns columns() {
    return {static_cast<std::ptrdiff_t>(inverse_.size()),
            inverse_.data(),
            Q_.data(),
            S_.data(),
            half_.data(),
            next_.data(),
            end_.data(),
            G1_.data(),
            V1_.data()};
  }

  double h = 0;
  SymmetricSolve C, K;
  Dense B, Z;

 private:
  /// Finds Y for a step of size t, starting from the current Y.
  bool solve(double t) {
    pass_->measure(columns(), t, A_.data(), P_.data(), E_.data());
    E_.diagonal().array() -= 1;
    return riccati_.solve(A_, P_, E_, Y_);
  }
  bool follow() {
    Y_.setZero();
    return !(continuation(1, [&](double t) {
               found_ = Y_;
               if (solve(t * h)) return true;
               Y_ = found_;
               return false;
             }) < 1);
  }

  Index n_, N_;
  std::unique_ptr<RattleTangentPass> pass_;
  ConstraintRiccati<double> riccati_;
  Dense A_, P_, E_, Y_, found_;
  Tiles inverse_, Q_, S_, half_, next_, end_, G1_, V1_;
};

/// RattleTangent for many columns: vectors one by one, in passes over packs of columns.
class WideRattleTangent final : public TangentMap {
 public:
  WideRattleTangent(const Scene& scene, const ColumnParameters& at)
      : n_(scene.Q().rows()),
        compensated_(scene.arithmetic() == Arithmetic::compensated),
        substeps_(scene.substeps()),
        unit_(binary_unit(at.lambda.maxCoeff())),
        h_(at.h / unit_),
        gamma_(symmetric_stages<double>(scene.order() > 0 ? scene.order() : 2)),
        parameters_(at) {}

  void start(const Dense&, const Dense& V) override {
    values_.emplace(parameters_.lambda / unit_, n_);
    vectors_.clear();
    for (Index v = 0; v < V.cols(); ++v) {
      Vector& x = vectors_.emplace_back(Vector{values_->zero(n_), values_->zero(n_), {}, {}, {}, 0});
      if (compensated_) x.Q_carry = x.S_carry = values_->zero(n_);
      for (Index j = 0; j < size(); ++j)
        for (Index a = 0; a < n_; ++a) {
          element(x.Q, n_, a, j) = V(a + 2 * n_ * j, v);
          element(x.S, n_, a, j) = V(a + n_ + 2 * n_ * j, v);
        }
      if (parameters_.by_lambda.col(v).isZero(0) && parameters_.by_h(v) == 0) continue;
      x.by_inverse = values_->zero(1);
      for (Index j = 0; j < size(); ++j)
        element(x.by_inverse, 1, 0, j) = -(parameters_.by_lambda(j, v) / unit_) *
                                         values_->inverse(j) * values_->inverse(j);
      x.by_h = parameters_.by_h(v) / unit_;
    }
    work_ = values_->zero(n_);
  }

  RunStatus step(const Dense& point) override {
    values_->set(point);
    const std::size_t stages = 2 * gamma_.size() - 1;
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < stages; ++stage) {
        const double gamma = gamma_[std::min(stage, stages - 1 - stage)];
        if (const RunStatus status = values_->step(gamma * h_); !status.reached()) return status;
        for (Vector& x : vectors_) move(x, gamma * x.by_h);
        values_->swap();
      }
    return {};
  }

  bool direct() const override { return false; }
  RunStatus at(std::int64_t) override { return {Outcome::solver_stalled, std::nullopt}; }

  void read(const Dense&, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v) {
      const Vector& x = vectors_[static_cast<std::size_t>(v)];
      for (Index j = 0; j < size(); ++j)
        for (Index a = 0; a < n_; ++a) {
          V(a + 2 * n_ * j, v) = element(x.Q, n_, a, j);
          V(a + n_ + 2 * n_ * j, v) = element(x.S, n_, a, j);
        }
    }
  }

 private:
  struct Vector {
    Tiles Q, S, Q_carry, S_carry;
    Tiles by_inverse;  ///< empty where the parameters are constant
    double by_h;
  };

  Index size() const { return parameters_.lambda.size(); }

  void move(Vector& x, double by_h) {
    stop_point(9 * static_cast<double>(n_ * n_ * size()));
    constexpr std::size_t most = SymmetricSolve::largest * SymmetricSolve::largest;
    double R[most], dB[most], dZ[most];
    const RattleColumns at = values_->columns();
    const RattleVector vector{x.Q.data(),
                              x.S.data(),
                              compensated_ ? x.Q_carry.data() : nullptr,
                              compensated_ ? x.S_carry.data() : nullptr,
                              x.by_inverse.empty() ? nullptr : x.by_inverse.data(),
                              by_h,
                              work_.data()};
    RattleTangentPass& pass = values_->pass();
    pass.begin(at, vector, values_->h, values_->B.data(), R);
    values_->C.solve(-1 / values_->h, R, dB);
    pass.move_Q(at, vector, values_->h, dB, values_->Z.data(), R);
    values_->K.solve(-1, R, dZ);
    pass.move_S(at, vector, dZ);
  }

  Index n_;
  bool compensated_;
  int substeps_;
  double unit_, h_;  ///< Λ and h are divided by the unit, as in RattleStiefel
  std::vector<double> gamma_;
  ColumnParameters parameters_;
  std::optional<WideRattleValues> values_;
  std::vector<Vector> vectors_;
  Tiles work_;
};

}  // namespace

std::unique_ptr<TangentMap> wide_rattle_tangent(const Scene& scene, const ColumnParameters& at) {
  return std::make_unique<WideRattleTangent>(scene, at);
}

}  // namespace stiefel
