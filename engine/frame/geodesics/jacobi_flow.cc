#include "engine/frame/geodesics/jacobi_flow.h"

#include <cmath>
#include <functional>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/geodesic_flow.h"
#include "engine/frame/geodesics/path.h"
#include "engine/methods/fehlberg.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using State = JacobiFlow::State;

template <template <class> class Form>
class JacobiFlowBy : public JacobiFlow {
 public:
  JacobiFlowBy(const VectorXd& lambda, Index n)
      : JacobiFlow(n, lambda.size()), lambda_(lambda), field_(lambda, n) {}

  void step(const State& x, double h, State& next, State& error) override {
    stop_point(connect_work::flow(n_, N_));
    slope_.resize(x.size());
    field_(x, slope_);
    fehlberg_.step(std::ref(field_), x, slope_, h, next, error);
  }

  State start(const MatrixXd& Q, const MatrixXd& V, const MatrixXd& directions) const override {
    const Index size = n_ * N_;
    State x(static_cast<std::size_t>(2 * size * (1 + directions.cols())));
    field_.block(x, 0) = Q;
    field_.block(x, 1) = Form<double>::momentum(lambda_, Q, V);
    auto all = fields(x);
    for (Index k = 0; k < directions.cols(); ++k)
      all.col(k).tail(size) =
          Form<double>::momentum(lambda_, Q, directions.col(k).reshaped(n_, N_)).reshaped();
    return x;
  }

 protected:
  VectorXd lambda_;
  GeodesicField<Form<double>, double> field_;
  Fehlberg<double> fehlberg_;
  State slope_;
};

class FrameJacobiFlow final : public JacobiFlowBy<FrameForm> {
 public:
  using JacobiFlowBy::JacobiFlowBy;

  MatrixXd basis(const MatrixXd& Q) const override {
    const MatrixXd Z = tangent_basis(Q);
    MatrixXd gram = Z.transpose() * weight().asDiagonal() * Z, E = Z.transpose();
    factor_positive(gram);
    divide_by_lower(gram, E);
    return E.transpose();
  }

  Coordinates coordinates(const State& x) const override {
    const MatrixXd E = basis(frame(x));
    const auto all = fields(const_cast<State&>(x));
    const Index size = n_ * N_;
    return {E.transpose() * (weight().asDiagonal() * all.topRows(size)),
            E.transpose() * all.bottomRows(size)};
  }

  double curvature(const State& x) const override {
    const MatrixXd Q = frame(x), K = Q * lambda_.cwiseInverse().asDiagonal() * Q.transpose();
    const MatrixXd V = field_.block(x, 1) * lambda_.cwiseInverse().asDiagonal();
    return V.norm() / std::sqrt(lambda_.minCoeff() * symmetric_eigenvalues(K)(0));
  }

 private:
  /// Returns Λ as the diagonal that acts on a tangent vector as a column.
  VectorXd weight() const { return lambda_.transpose().replicate(n_, 1).reshaped(); }
};

class BodyJacobiFlow final : public JacobiFlowBy<BodyForm> {
 public:
  BodyJacobiFlow(const VectorXd& lambda, Index n) : JacobiFlowBy(lambda, n), root_(degrees()) {
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
    const MatrixXd Q = frame(x), M = field_.block(x, 1), Omega = inverse(M);
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
    const MatrixXd M = field_.block(x, 1), Omega = inverse(M), torque = bracket(M, Omega),
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

  VectorXd root_;  ///< √(λ_i + λ_j), i < j
};

}  // namespace

std::unique_ptr<JacobiFlow> JacobiFlow::make(const VectorXd& lambda, Index n) {
  if (n == lambda.size()) return std::make_unique<BodyJacobiFlow>(lambda, n);
  return std::make_unique<FrameJacobiFlow>(lambda, n);
}

}  // namespace stiefel
