#include <cmath>
#include <optional>

#include "engine/body/j_d/j_d_n.h"
#include "engine/body/principal_branch.h"
#include "engine/body/rigid_tangents.h"
#include "engine/dense/decompositions.h"
#include "engine/dense/history.h"
#include "engine/dense/inertia_operator.h"
#include "engine/methods/symmetric_stages.h"
#include "engine/methods/variational.h"
#include "engine/numbers/compensated.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// δU for a step U = I + X of UΛ − ΛUᵀ = hM, from K = δUΛ − ΛδUᵀ, skew. With w_ij = 2λ_i/(λ_i +
/// λ_j), every symmetric S gives a solution, and UᵀδU skew fixes it:
///
///     δU = J⁻¹(K) + w∘S,   S = −½(P + Pᵀ),   P = XᵀδU.
///
/// The sweeps of RotationCorrection, which has the same derivative, in working precision. Where
/// they do not converge, δU = Uυ with υΛU + (ΛU)ᵀυ = UᵀKU, υ skew, by the Schur form of ΛU.
class DifferentialOfU {
 public:
  explicit DifferentialOfU(const Eigen::VectorXd& lambda)
      : lambda_(lambda),
        weight_(rotation_weights(lambda)),
        omega_(weight_),
        before_(weight_),
        P_(weight_),
        has_weights_(!(lambda.minCoeff() < 0)) {}

  /// Takes U − I and h‖Ω‖.
  void set(const Dense& X, double sine) {
    X_ = X;
    sine_ = sine;
    factored_ = false;
  }
  /// Sets dU to δU, and S, from which the sweeps start, to its symmetric part.
  void operator()(const Dense& K, Dense& dU, Dense& S) {
    if (has_weights_ && sine_ < 1 && sweep(K, dU, S)) return;
    solve(K, dU);
    S = (dU + dU.transpose()) / 2;
  }

 private:
  bool sweep(const Dense& K, Dense& dU, Dense& S) {
    const Index N = lambda_.size();
    const double s = sine_, c = (1 + std::sqrt(1 - s * s)) / 2,
                 rate = s / (c + std::sqrt(c * c + s * s));
    inverse_inertia(lambda_, K, omega_);
    const double enough = 0x1p-52 * s * omega_.cwiseAbs().maxCoeff();
    const int most = s > 0 ? 3 + static_cast<int>(std::log(0x1p-52) / std::log(rate)) : 1;
    dU = omega_ + weight_.cwiseProduct(S);
    before_ = S;
    double a = 1 / c, b = 0, left = 0;
    for (int k = 0; k < most; ++k) {
      stop_point(static_cast<double>(N * dU.size()));
      P_.noalias() = X_.transpose() * dU;
      left = 0;
      for (Index j = 0; j < N; ++j)
        for (Index i = 0; i <= j; ++i) {
          const double now = S(i, j), r = -(P_(i, j) + P_(j, i)) / 2 - now,
                       next = now + a * r + b * (now - before_(i, j));
          left = std::max(left, std::abs(r));
          before_(i, j) = now;
          S(i, j) = S(j, i) = next;
        }
      dU = omega_ + weight_.cwiseProduct(S);
      if (left <= enough) break;
      a = k == 0 ? 2 * c / (2 * c * c + s * s) : 1 / (c + s * s / 4 * a);
      b = c * a - 1;
    }
    return left <= 64 * enough;
  }
  void solve(const Dense& K, Dense& dU) {
    Dense U = X_;
    U.diagonal().array() += 1;
    if (!lyapunov_) lyapunov_.emplace(lambda_.size());
    if (!factored_) lyapunov_->factor(lambda_.asDiagonal() * U);
    factored_ = true;
    P_.noalias() = K * U;
    Dense upsilon(P_.rows(), P_.cols());
    upsilon.noalias() = U.transpose() * P_;
    lyapunov_->solve(upsilon, upsilon);
    upsilon = ((upsilon - upsilon.transpose()) / 2).eval();
    dU.noalias() = U * upsilon;
  }

  Eigen::VectorXd lambda_;
  Dense weight_, omega_, before_, P_, X_;
  double sine_ = 0;
  bool has_weights_, factored_ = false;
  std::optional<Lyapunov<double>> lyapunov_;
};

/// Moves (η, δM) by the steps of the discrete rigid body in any dimension, Q ↦ QU, M ↦ M′, UΛ − ΛUᵀ
/// = hM, ΛU − UᵀΛ = hM′. With X = U − I and K = hδM + δhM + δΛUᵀ − UδΛ,
///
///     δUΛ − ΛδUᵀ = K,   η′ = Uᵀ(ηU + δU),
///     δM′ = δM + (2/h)((λ_i − λ_j)(S_ij − T_ij δh/h) + (δλ_i − δλ_j)T_ij),
///
/// S and T the symmetric parts of δU and X.
class LargeBodyTangent final : public TangentMap {
 public:
  LargeBodyTangent(const Scene& scene, const TangentParameters& at)
      : substeps_(scene.substeps()),
        N_(scene.dimension()),
        arithmetic_(scene.arithmetic()),
        parameters_(at),
        gamma_(symmetric_stages<double>(scene.order() > 0 ? scene.order() : 2)),
        differential_(at.lambda),
        M_(N_, N_),
        X_(M_),
        T_(M_),
        K_(M_),
        dU_(M_),
        S_(M_),
        v_(N_),
        Av_(N_) {
    branches_.reserve(gamma_.size());
    for (const double gamma : gamma_) {
      stop_point();
      branches_.emplace_back(at.lambda, gamma * at.h);
    }
  }

  void start(const Dense& point, const Dense& V) override {
    const Index rows = V.rows() / N_;
    has_frame_ = rows > N_;
    vectors_.clear();
    for (Index v = 0; v < V.cols(); ++v) {
      stop_point();
      const Dense block = V.col(v).reshaped(rows, N_);
      const Dense M = block.bottomRows(N_);
      vectors_.emplace_back(N_, count() == 1);
      vectors_.back().m = Sum((M - M.transpose()) / 2, arithmetic_);
      if (!has_frame_) continue;
      K_.noalias() = point.topRows(N_).transpose() * block.topRows(N_);
      vectors_.back().eta = Sum((K_ - K_.transpose()) / 2, arithmetic_);
    }
    memories_.clear();
    for (std::size_t stage = 0; stage < count(); ++stage)
      memories_.push_back(branches_[folded(stage)].memory());
  }

  RunStatus step(const Dense& point) override {
    Sum x(point.bottomRows(N_), Arithmetic::plain);
    for (int k = 0; k < substeps_; ++k)
      for (std::size_t stage = 0; stage < count(); ++stage) {
        const double h = gamma_[folded(stage)] * parameters_.h;
        auto& branch = branches_[folded(stage)];
        M_ = x.value;
        if (const auto status = branch.solve(x, memories_[stage]); !status.reached()) return status;
        branch.inverse().transport(x, memories_[stage]);
        X_ = branch.inverse().U_minus_I();
        T_ = (X_ + X_.transpose()) / 2;
        inverse_inertia(parameters_.lambda, M_, K_);
        differential_.set(X_, std::abs(h) * norm_of_skew(K_, v_, Av_));
        for (Index v = 0; v < static_cast<Index>(vectors_.size()); ++v)
          move(v, h, gamma_[folded(stage)] * parameters_.by_h(v));
      }
    return {};
  }

  void read(const Dense& point, Dense& V) const override {
    const Index rows = V.rows() / N_;
    Dense dQ(N_, N_);
    for (Index v = 0; v < V.cols(); ++v) {
      stop_point();
      auto block = V.col(v).reshaped(rows, N_);
      block.bottomRows(N_) = vectors_[static_cast<std::size_t>(v)].m.value;
      if (!has_frame_) continue;
      dQ.noalias() = point.topRows(N_) * vectors_[static_cast<std::size_t>(v)].eta.value;
      block.topRows(N_) = dQ;
    }
  }

 private:
  using Sum = Accumulator<Dense>;
  struct Vector {
    Vector(Index N, bool extrapolates) : past(extrapolates ? N : 0, extrapolates ? N : 0) {}

    Sum eta, m;
    History<double, 5> past;  ///< S of the last steps, for a step of one stage
  };

  std::size_t count() const { return 2 * gamma_.size() - 1; }
  std::size_t folded(std::size_t stage) const { return std::min(stage, count() - 1 - stage); }

  void move(Index v, double h, double dh) {
    auto& [eta, m, past] = vectors_[static_cast<std::size_t>(v)];
    const Eigen::VectorXd& lambda = parameters_.lambda;
    const auto by_lambda = parameters_.by_lambda.col(v);
    const bool varies = dh != 0 || !by_lambda.isZero(0);
    K_ = h * m.value;
    if (varies) {
      K_ += dh * M_;
      for (Index j = 0; j < N_; ++j)
        for (Index i = 0; i < j; ++i) {
          const double change = by_lambda(i) * X_(j, i) - X_(i, j) * by_lambda(j);
          K_(i, j) += change;
          K_(j, i) -= change;
        }
    }
    const bool extrapolates = count() == 1;
    if (!extrapolates || !past.predict(S_)) S_.setZero();
    differential_(K_, dU_, S_);
    if (extrapolates) past.push(S_);
    for (Index j = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i) {
        double change = (lambda(i) - lambda(j)) * S_(i, j);
        if (varies)
          change += (by_lambda(i) - by_lambda(j) - (lambda(i) - lambda(j)) * dh / h) * T_(i, j);
        add_skew(m, i, j, 2 / h * change);
      }
    if (!has_frame_) return;
    // η′ − η = A + XᵀB, A = ηX + δU, B = η + A.
    stop_point(2 * static_cast<double>(N_ * N_ * N_));
    dU_.noalias() += eta.value * X_;
    K_ = eta.value + dU_;
    S_.noalias() = X_.transpose() * K_;
    for (Index j = 0; j < N_; ++j)
      for (Index i = 0; i < j; ++i)
        add_skew(eta, i, j, (dU_(i, j) - dU_(j, i) + S_(i, j) - S_(j, i)) / 2);
  }

  static void add_skew(Sum& sum, Index i, Index j, double increment) {
    sum.add_scalar(i, j, increment);
    sum.mirror(i, j, j, i);
  }

  int substeps_;
  Index N_;
  Arithmetic arithmetic_;
  bool has_frame_ = false;
  TangentParameters parameters_;
  std::vector<double> gamma_;
  std::vector<PrincipalBranch<JDInverseN>> branches_;
  std::vector<JDInverseN::Memory> memories_;  ///< of the stages
  DifferentialOfU differential_;
  Dense M_, X_, T_;  ///< M, U − I and its symmetric part, of a stage
  Dense K_, dU_, S_;
  Eigen::VectorXd v_, Av_;
  std::vector<Vector> vectors_;
};

}  // namespace

std::unique_ptr<TangentMap> large_body_tangent(const Scene& scene, const TangentParameters& at) {
  return std::make_unique<LargeBodyTangent>(scene, at);
}

}  // namespace stiefel
