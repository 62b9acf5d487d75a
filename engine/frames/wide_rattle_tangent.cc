#include "engine/frames/passes/rattle_tangent_pass.h"
#include "engine/frames/rattle_tangent.h"
#include "engine/frames/rattle_tangent_of.h"
#include "engine/frames/symmetric_solve.h"
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

/// The values of a step of RATTLE, in the letters of RattleTangentPass, and vectors that are moved
/// one by one, in passes over packs of columns.
class RattleTiles {
 public:
  RattleTiles(const Eigen::VectorXd& lambda, Index n, bool compensated)
      : n_(n),
        N_(lambda.size()),
        compensated_(compensated),
        pass_(make_rattle_tangent_pass(n)),
        multiplier_(n),
        C_(n),
        K_(n),
        B_(n, n),
        Z_(n, n) {
    inverse_ = zero(1);
    for (Index j = 0; j < N_; ++j) element(inverse_, 1, 0, j) = 1 / lambda(j);
    Q_ = S_ = half_ = next_ = end_ = G1_ = V1_ = work_ = zero(n);
  }

  void begin(Index vectors) {
    vectors_.assign(static_cast<std::size_t>(vectors), {zero(n_), zero(n_), {}, {}, {}, 0});
    if (compensated_)
      for (Vector& x : vectors_) x.Q_carry = x.S_carry = zero(n_);
    Z_.setZero();
  }
  void set(Index v, Index a, Index j, double dQ, double dS) {
    Vector& x = vectors_[static_cast<std::size_t>(v)];
    element(x.Q, n_, a, j) = dQ;
    element(x.S, n_, a, j) = dS;
  }
  std::pair<double, double> get(Index v, Index a, Index j) const {
    const Vector& x = vectors_[static_cast<std::size_t>(v)];
    return {element(x.Q, n_, a, j), element(x.S, n_, a, j)};
  }
  void vary(Index v, const Eigen::ArrayXd& by_inverse, double by_h) {
    Vector& x = vectors_[static_cast<std::size_t>(v)];
    x.by_inverse = zero(1);
    for (Index j = 0; j < N_; ++j) element(x.by_inverse, 1, 0, j) = by_inverse(j);
    x.by_h = by_h;
  }

  void set(const Dense& point) {
    for (Index j = 0; j < N_; ++j)
      for (Index a = 0; a < n_; ++a) {
        element(Q_, n_, a, j) = point(a, j);
        element(S_, n_, a, j) = point(n_ + a, j);
      }
  }
  RunStatus step(double size) {
    stop_point(12 * static_cast<double>(n_ * n_ * N_));
    h_ = size;
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
    K_.solve(-1, E.data(), Z_.data());
    pass_->finish(x, Z_.data());
    return {};
  }
  void move(double gamma) {
    for (Vector& x : vectors_) move(x, gamma * x.by_h);
  }
  void swap() {
    Q_.swap(next_);
    S_.swap(end_);
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

  void move(Vector& x, double by_h) {
    stop_point(9 * static_cast<double>(n_ * n_ * N_));
    constexpr std::size_t most = SymmetricSolve::largest * SymmetricSolve::largest;
    double R[most], dB[most], dZ[most];
    const RattleColumns at = columns();
    const RattleVector vector{x.Q.data(),
                              x.S.data(),
                              compensated_ ? x.Q_carry.data() : nullptr,
                              compensated_ ? x.S_carry.data() : nullptr,
                              x.by_inverse.empty() ? nullptr : x.by_inverse.data(),
                              by_h,
                              work_.data()};
    pass_->begin(at, vector, h_, B_.data(), R);
    C_.solve(-1 / h_, R, dB);
    pass_->move_Q(at, vector, h_, dB, Z_.data(), R);
    K_.solve(-1, R, dZ);
    pass_->move_S(at, vector, dZ);
  }

  Index n_, N_;
  bool compensated_;
  double h_ = 0;
  std::unique_ptr<RattleTangentPass> pass_;
  RattleMultiplier multiplier_;
  SymmetricSolve C_, K_;
  Dense B_, Z_;
  Tiles inverse_, Q_, S_, half_, next_, end_, G1_, V1_, work_;
  std::vector<Vector> vectors_;
};

}  // namespace

std::unique_ptr<TangentMap> wide_rattle_tangent(const Scene& scene, const ColumnParameters& at) {
  return std::make_unique<RattleTangentOf<RattleTiles>>(scene, at);
}

}  // namespace stiefel
