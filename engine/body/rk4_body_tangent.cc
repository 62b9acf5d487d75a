#include <array>

#include "engine/body/rigid_tangents.h"
#include "engine/dense/so_3.h"
#include "engine/dense/so_n.h"
#include "engine/numbers/compensated.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

// Two spaces of states x. `field` computes (QY, [Λ, ½(ΩY + YΩ)]), bilinear in (Q, Ω) and Y: ẋ for
// Y = Ω.

/// Matrices, Q over M or M alone.
struct Matrices : SoN<double> {
  static auto momentum(auto& x) { return x.bottomRows(x.cols()); }
  static void inverse_inertia(const Lambda& lambda, const State& x, Algebra& Omega) {
    stiefel::inverse_inertia(lambda, momentum(x), 2.0, Omega);
  }
  static Algebra J(const Lambda& lambda, const Algebra& Omega) {
    return lambda.asDiagonal() * Omega + Omega * lambda.asDiagonal();
  }
  static void field(const Lambda& lambda, const State& x, const Algebra& Omega, const Algebra& Y,
                    State& out) {
    const Index N = Y.cols(), top = x.rows() - N;
    stop_point(2 * static_cast<double>(N * Y.size()));
    out.resize(x.rows(), N);
    out.topRows(top).noalias() = x.topRows(top) * Y;
    auto bracket = out.bottomRows(N);
    bracket.noalias() = Omega * Y;  // YΩ is its transpose
    for (Index j = 0; j < N; ++j) {
      bracket(j, j) = 0;
      for (Index i = 0; i < j; ++i) {
        bracket(i, j) = (lambda(i) - lambda(j)) * (bracket(i, j) + bracket(j, i)) / 2;
        bracket(j, i) = -bracket(i, j);
      }
    }
  }

  /// Vectors at a point are blocks already.
  static State of_block(const Dense&, const Dense& block) { return block; }
  static Dense block(const Dense&, const State& dx) { return dx; }
};

/// Three dimensions: (q; m), or m alone.
template <bool frame>
struct Quaternions : So3<double, frame> {
  using Space = So3<double, frame>;
  using typename Space::State, typename Space::Algebra, typename Space::Lambda;

  static auto momentum(auto& x) { return x.template tail<3>(); }
  static Algebra J(const Lambda& lambda, const Algebra& omega) {
    return (lambda.sum() - lambda.array()) * omega.array();
  }
  static void field(const Lambda& lambda, const State& x, const Algebra& omega, const Algebra& y,
                    State& out) {
    if constexpr (frame) out.template head<4>() = Space::quaternion_times(x, Algebra(y / 2));
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      momentum(out)(k) = (lambda(j) - lambda(i)) * (omega(i) * y(j) + omega(j) * y(i)) / 2;
    }
  }

  /// δq = ½q∘(0, η).
  static State of_block(const Dense& point, const Dense& block) {
    const Dense x = in_body(point, block.reshaped());
    State dx;
    momentum(dx) = vee(x.bottomRows(3));
    if constexpr (frame)
      dx.template head<4>() =
          Space::quaternion_times(Eigen::Vector4d(point.topRows(4)), vee(x.topRows(3) / 2));
    return dx;
  }
  /// Q is a form in q, so that δQ is its polar form with δq.
  static Dense block(const Dense& point, const State& dx) {
    Dense out(frame ? 6 : 3, 3);
    out.bottomRows(3) = hat(momentum(dx));
    if constexpr (frame) {
      const Eigen::Vector4d q = point.topRows(4), dq = dx.template head<4>();
      out.topRows(3) = (rotation_matrix<double>(q + dq) - rotation_matrix<double>(q - dq)) / 2;
    }
    return out;
  }
};

/// Rk4 on x = (Q, M), Ω = J⁻¹(M), ẋ = (QΩ, [Λ, Ω²]), and its derivative stage by stage by the chain
/// rule.
template <class Space>
class Rk4BodyTangent final : public TangentMap {
 public:
  Rk4BodyTangent(const Scene& scene, const TangentParameters& at)
      : substeps_(scene.substeps()),
        arithmetic_(scene.arithmetic()),
        parameters_(at),
        lambda_(at.lambda) {
    dOmega_.setZero(lambda_.size(), dOmega_.cols() == 1 ? 1 : lambda_.size());
    for (Stage& stage : stages_) stage.Omega = dOmega_;
  }

  void start(const Dense& point, const Dense& V) override {
    const Index N = lambda_.size();
    vectors_.clear();
    for (Index v = 0; v < V.cols(); ++v) {
      const Dense block = V.col(v).reshaped(V.rows() / N, N);
      vectors_.emplace_back(Space::of_block(point, block), arithmetic_);
    }
  }

  RunStatus step(const Dense& point) override {
    State x = point;
    for (int k = 0; k < substeps_; ++k) {
      stop_point(600 * static_cast<double>(vectors_.size() + 1));
      find_values(x);
      for (Index v = 0; v < std::ssize(vectors_); ++v) move(v);
      x += parameters_.h / 6 * sum_k_;
    }
    return {};
  }

  void read(const Dense& point, Dense& V) const override {
    for (Index v = 0; v < V.cols(); ++v)
      V.col(v) = Space::block(point, vectors_[static_cast<std::size_t>(v)].value).reshaped();
  }

 private:
  using State = typename Space::State;
  using Algebra = typename Space::Algebra;
  using Lambda = typename Space::Lambda;
  static constexpr double nodes_[] = {0, 0.5, 0.5, 1}, weights_[] = {1, 2, 2, 1};

  struct Stage {
    State x, k;
    Algebra Omega;
  };

  void find_values(const State& x) {
    for (std::size_t s = 0; s < 4; ++s) {
      Stage& at = stages_[s];
      at.x = x;
      if (s > 0) at.x += nodes_[s] * parameters_.h * stages_[s - 1].k;
      Space::inverse_inertia(lambda_, at.x, at.Omega);
      Space::field(lambda_, at.x, at.Omega, at.Omega, at.k);
      s == 0 ? sum_k_ = at.k : sum_k_ += weights_[s] * at.k;
    }
  }

  void move(Index v) {
    auto& sum = vectors_[static_cast<std::size_t>(v)];
    const bool varies = !parameters_.constant(v);
    const Lambda dlambda = parameters_.by_lambda.col(v);
    const double h = parameters_.h, dh = parameters_.by_h(v);
    for (std::size_t s = 0; s < 4; ++s) {
      const Stage& at = stages_[s];
      dx_ = sum.value;
      if (s > 0) dx_ += nodes_[s] * h * dk_;
      if (s > 0 && varies) dx_ += nodes_[s] * dh * stages_[s - 1].k;
      if (varies) Space::momentum(dx_) -= Space::J(dlambda, at.Omega);
      Space::inverse_inertia(lambda_, dx_, dOmega_);
      Space::field(lambda_, dx_, dOmega_, at.Omega, dk_);
      Space::field(lambda_, at.x, at.Omega, dOmega_, more_);
      dk_ += more_;
      if (varies) {
        Space::field(dlambda, at.x, at.Omega, at.Omega, more_);
        Space::momentum(dk_) += Space::momentum(more_);
      }
      s == 0 ? sum_dk_ = dk_ : sum_dk_ += weights_[s] * dk_;
    }
    sum_dk_ *= h / 6;
    if (varies) sum_dk_ += dh / 6 * sum_k_;
    sum.add(sum_dk_);
  }

  int substeps_;
  Arithmetic arithmetic_;
  TangentParameters parameters_;
  Lambda lambda_;
  std::array<Stage, 4> stages_;
  State sum_k_, dx_, dk_, sum_dk_, more_;
  Algebra dOmega_;
  std::vector<Accumulator<State>> vectors_;
};

}  // namespace

std::unique_ptr<TangentMap> rk4_body_tangent(const Scene& scene, const TangentParameters& at) {
  if (scene.dimension() != 3) return std::make_unique<Rk4BodyTangent<Matrices>>(scene, at);
  if (scene.has_frame()) return std::make_unique<Rk4BodyTangent<Quaternions<true>>>(scene, at);
  return std::make_unique<Rk4BodyTangent<Quaternions<false>>>(scene, at);
}

}  // namespace stiefel
