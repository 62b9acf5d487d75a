#include "engine/frame/geodesics/jacobi_flow.h"

#include <cmath>

#include "engine/dense/decompositions.h"
#include "engine/dense/inertia_operator.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_series.h"
#include "engine/frame/geodesics/path.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using State = JacobiFlow::State;

/// n < N ([ST] (37)–(39)): Q̇ = SΛ⁻¹, Ṡ = BQ, KB + BK = −2Q̇Q̇ᵀ, K = QΛ⁻¹Qᵀ.
class FrameJacobiFlow final : public JacobiFlow {
 public:
  FrameJacobiFlow(const VectorXd& lambda, Index n) : JacobiFlow(lambda, n), lyapunov_(n) {}

  MatrixXd basis(const MatrixXd& Q) const override {
    const MatrixXd Z = tangent_basis(Q);
    MatrixXd gram = Z.transpose() * weight().asDiagonal() * Z, E = Z.transpose();
    factor_positive(gram);
    divide_by_lower(gram, E);
    return E.transpose();
  }

  Coordinates coordinates(const State& x) const override {
    const MatrixXd E = basis(block(x, 0));
    const auto all = fields(const_cast<State&>(x));
    const Index size = n_ * N_;
    return {E.transpose() * (weight().asDiagonal() * all.topRows(size)),
            E.transpose() * all.bottomRows(size)};
  }

  double curvature(const State& x) const override {
    const MatrixXd Q = block(x, 0), K = Q * lambda_.cwiseInverse().asDiagonal() * Q.transpose();
    const MatrixXd V = block(x, 1) * lambda_.cwiseInverse().asDiagonal();
    return V.norm() / std::sqrt(lambda_.minCoeff() * symmetric_eigenvalues(K)(0));
  }

 private:
  void field(const Values& Q, const Values& S, Block dQ, Block dS) override {
    V_ = S * lambda_.cwiseInverse().asDiagonal();
    G_ = Q * lambda_.cwiseInverse().asDiagonal();
    K_ = G_.lazyProduct(Q.transpose());
    lyapunov_.factor(K_);
    B_ = -2 * V_.lazyProduct(V_.transpose());
    lyapunov_.solve(B_, B_);
    dQ = V_;
    dS = B_.lazyProduct(Q);
  }

  void variation(const Values& Q, const Values&, const Values& q, const Values& s, Block dq,
                 Block ds) override {
    const MatrixXd v = s * lambda_.cwiseInverse().asDiagonal(),
                   half_k = q.lazyProduct(G_.transpose()), k = half_k + half_k.transpose(),
                   kB = k.lazyProduct(B_), vV = v.lazyProduct(V_.transpose());
    MatrixXd b = -2 * (vV + vV.transpose()) - kB - kB.transpose();
    lyapunov_.solve(b, b);
    dq = v;
    ds = b.lazyProduct(Q) + B_.lazyProduct(q);
  }

  /// Returns Λ as the diagonal that acts on a tangent vector as a column.
  VectorXd weight() const { return lambda_.transpose().replicate(n_, 1).reshaped(); }

  SymmetricLyapunov<double> lyapunov_;
  MatrixXd V_, G_, K_, B_;
};

/// n = N ([RB] (2.2), (2.3)): Q̇ = QΩ, Ṁ = [M, Ω], Ω_ij = M_ij/(λ_i + λ_j). No λ_i is a divisor.
class BodyJacobiFlow final : public JacobiFlow {
 public:
  BodyJacobiFlow(const VectorXd& lambda, Index n) : JacobiFlow(lambda, n), root_(degrees()) {
    for (Index j = 0, k = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i, ++k) root_(k) = std::sqrt(lambda(i) + lambda(j));
  }

  MatrixXd basis(const MatrixXd& Q) const override {
    MatrixXd E(N_ * N_, degrees());
    for (Index j = 0, k = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i, ++k) {
        MatrixXd omega = MatrixXd::Zero(N_, N_);
        omega(i, j) = 1 / root_(k);
        omega(j, i) = -omega(i, j);
        E.col(k) = (Q * omega).reshaped();
      }
    return E;
  }

  Coordinates coordinates(const State& x) const override {
    const auto all = fields(const_cast<State&>(x));
    const MatrixXd Q = block(x, 0), M = block(x, 1), Omega = inverse(M);
    Coordinates out{MatrixXd(degrees(), all.cols()), MatrixXd(degrees(), all.cols())};
    for (Index k = 0; k < all.cols(); ++k) {
      const MatrixXd turn = Q.transpose() * all.col(k).head(N_ * N_).reshaped(N_, N_),
                     eta = (turn - turn.transpose()) / 2,
                     m = all.col(k).tail(N_ * N_).reshaped(N_, N_),
                     shift = inertia(bracket(eta, Omega)) - bracket(M, eta) -
                             bracket(inertia(eta), Omega);
      out.A.col(k) = root_.cwiseProduct(upper(eta));
      out.B.col(k) = upper(m + shift / 2).cwiseQuotient(root_);
    }
    return out;
  }

  /// Computes R from D_t²η = −Rη for the fields with D_tη = 0, for which δΩ = −Lη.
  double curvature(const State& x) const override {
    const MatrixXd M = block(x, 1), Omega = inverse(M), torque = bracket(M, Omega),
                   rate = inverse(torque);
    const auto L = [&](const MatrixXd& omega, const MatrixXd& m, const MatrixXd& eta) -> MatrixXd {
      return (bracket(eta, omega) - inverse(bracket(inertia(eta), omega) + bracket(m, eta))) / 2;
    };
    MatrixXd R(degrees(), degrees());
    for (Index j = 0, k = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i, ++k) {
        MatrixXd eta = MatrixXd::Zero(N_, N_);
        eta(i, j) = 1 / root_(k);
        eta(j, i) = -eta(i, j);
        const MatrixXd l = L(Omega, M, eta),
                       second = L(rate, torque, eta) + L(Omega, M, bracket(eta, Omega) - l) -
                                inverse(bracket(inertia(l), Omega) + bracket(M, l));
        R.col(k) = -root_.cwiseProduct(upper(second));
      }
    return std::sqrt(R.norm());
  }

 private:
  void field(const Values& Q, const Values& M, Block dQ, Block dM) override {
    Omega_ = inverse(M);
    dQ = Q.lazyProduct(Omega_);
    dM = M.lazyProduct(Omega_) - Omega_.lazyProduct(M);
  }

  void variation(const Values& Q, const Values& M, const Values& q, const Values& m, Block dq,
                 Block dm) override {
    const MatrixXd omega = inverse(m);
    dq = q.lazyProduct(Omega_) + Q.lazyProduct(omega);
    dm =
        m.lazyProduct(Omega_) - Omega_.lazyProduct(m) + M.lazyProduct(omega) - omega.lazyProduct(M);
  }

  static MatrixXd bracket(const MatrixXd& a, const MatrixXd& b) { return a * b - b * a; }
  MatrixXd inverse(const MatrixXd& m) const { return inverse_inertia<double>(lambda_, m); }
  MatrixXd inertia(const MatrixXd& omega) const {
    return lambda_.asDiagonal() * omega + omega * lambda_.asDiagonal();
  }
  VectorXd upper(const MatrixXd& m) const {
    VectorXd out(degrees());
    for (Index j = 0, k = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i, ++k) out(k) = m(i, j);
    return out;
  }

  MatrixXd Omega_;
  VectorXd root_;  ///< √(λ_i + λ_j), i < j
};

}  // namespace

State JacobiFlow::start(const MatrixXd& Q, const MatrixXd& V, const MatrixXd& directions) const {
  const Index size = n_ * N_;
  State x(static_cast<std::size_t>(2 * size * (1 + directions.cols())));
  block(x, 0) = Q;
  block(x, 1) = momentum(lambda_, Q, V);
  auto all = fields(x);
  for (Index k = 0; k < directions.cols(); ++k)
    all.col(k).tail(size) = momentum(lambda_, Q, directions.col(k).reshaped(n_, N_)).reshaped();
  return x;
}

void JacobiFlow::step(const State& x, double h, State& next, State& error) {
  stop_point(12 * connect_work::frame(n_, N_));
  const auto derivative = [&](const State& at, State& dx, double) {
    field(block(at, 0), block(at, 1), block(dx, 0), block(dx, 1));
    const std::size_t blocks = at.size() / static_cast<std::size_t>(n_ * N_);
    for (std::size_t k = 2; k < blocks; k += 2) {
      stop_point(1.5 * connect_work::frame(n_, N_));
      variation(block(at, 0), block(at, 1), block(at, k), block(at, k + 1), block(dx, k),
                block(dx, k + 1));
    }
  };
  next.resize(x.size());
  error.resize(x.size());
  fehlberg_.do_step(derivative, x, 0.0, next, h, error);
}

std::unique_ptr<JacobiFlow> JacobiFlow::make(const VectorXd& lambda, Index n) {
  if (n == lambda.size()) return std::make_unique<BodyJacobiFlow>(lambda, n);
  return std::make_unique<FrameJacobiFlow>(lambda, n);
}

}  // namespace stiefel
