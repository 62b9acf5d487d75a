#include "engine/frames/frame_tangents.h"

#include "engine/frames/body/discrete_stiefel.h"
#include "engine/laws/tangent_spaces.h"
#include "engine/linalg/matrix_equations/symmetric_solve.h"
#include "engine/methods/variational.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Dense = Eigen::MatrixXd;
using Index = Eigen::Index;

/// QQᵀ = I, any lower block.
Dense tangent_to_costates(const Dense& x, const Dense& G) {
  Dense T = G;
  const Index n = x.rows() / 2;
  T.topRows(n) = tangent_to_frames<double>(x.topRows(n), G.topRows(n));
  return T;
}

/// A scene makes S tangent: QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ = 0 for S − YQ, so that dS = −dY Q with
///
///     K dY + dY K = −(C + Cᵀ),   C = Q (dΛ/Λ²) Sᵀ,   K = QΛ⁻¹Qᵀ.
Dense frames_by_inertia(const Eigen::VectorXd& lambda, const Dense& x) {
  const Index n = x.rows() / 2;
  const auto Q = x.topRows(n), S = x.bottomRows(n);
  SymmetricLyapunov<double> lyapunov(n);
  lyapunov.factor(Q * lambda.cwiseInverse().asDiagonal() * Q.transpose());
  Dense out = Dense::Zero(x.size(), x.cols()), dY(n, n);
  for (Index k = 0; k < x.cols(); ++k) {
    stop_point(2 * static_cast<double>(n * Q.size()));
    const Dense C = Q.col(k) * S.col(k).transpose() / (lambda(k) * lambda(k));
    lyapunov.solve(-(C + C.transpose()), dY);
    out.col(k).reshaped(x.rows(), x.cols()).bottomRows(n) = -dY * Q;
  }
  return out;
}

TangentSpace cotangent_of_frames(const Scene& scene) {
  const CotangentOfFrames<double> frames{scene.inertia()};
  return {[frames](const Dense& x, const Dense& G) { return frames.tangent(x, G); },
          tangent_to_costates,
          [lambda = frames.lambda](const Dense& x) { return frames_by_inertia(lambda, x); }};
}

/// Two frames.
TangentSpace pairs_of_frames(const Scene&) {
  return {[](const Dense& x, const Dense& G) {
    const Index n = x.rows() / 2;
    return stacked_pair<double>(tangent_to_frames<double>(x.topRows(n), G.topRows(n)),
                                tangent_to_frames<double>(x.bottomRows(n), G.bottomRows(n)));
  }};
}

/// Moves (δQ_{k−1}, δQ_k) by the steps of the discrete variational problem, [ST] (55):
///
///     Q_{k+1} = BQ_kΛ⁻¹ − Q_{k−1},   δQ_{k+1} = δB Q_kΛ⁻¹ + W,
///     W = BδQ_kΛ⁻¹ + BQ_kδΛ⁻¹ − δQ_{k−1},   δB C + CᵀδB = −(WQ_{k+1}ᵀ + Q_{k+1}Wᵀ),
///
/// C = Q_kΛ⁻¹Q_{k+1}ᵀ. The step size is a unit of time, on which no frame depends.
class DiscreteStiefelTangent final : public TangentMap {
 public:
  DiscreteStiefelTangent(const Scene& scene, const TangentParameters& at)
      : n_(scene.Q().rows()),
        substeps_(scene.substeps()),
        map_(at.lambda, n_),
        parameters_(at),
        solve_(n_) {}

  void start(const Dense&, const Dense& V) override {
    vectors_.resize(V.rows(), V.cols());
    for (Index v = 0; v < V.cols(); ++v) {
      stop_point();
      vectors_.col(v) = V.col(v);
    }
  }

  RunStatus step(const Dense& point) override {
    auto state = map_.start(point);
    const auto inverse = parameters_.lambda.cwiseInverse();
    for (int k = 0; k < substeps_; ++k) {
      const Dense now = state.x.value, Q = now.bottomRows(n_);
      if (const RunStatus status = map_.step(state); !status.reached()) return status;
      const Dense next = state.x.value.bottomRows(n_), bar = Q * inverse.asDiagonal();
      stop_point(3 * static_cast<double>(n_ * Q.size()));
      const Dense sum = (next + now.topRows(n_)) * parameters_.lambda.asDiagonal(),
                  B = sum * Q.transpose();
      solve_.factor(bar * next.transpose());
      Dense dB(n_, n_);
      for (Index v = 0; v < vectors_.cols(); ++v) {
        stop_point(3 * static_cast<double>(n_ * Q.size()));
        auto vector = vectors_.col(v).reshaped(2 * n_, Q.cols());
        const Dense dQ = vector.bottomRows(n_);
        const Eigen::VectorXd by_inverse =
            -parameters_.by_lambda.col(v).array() * inverse.array().square();
        Dense W = B * (dQ * inverse.asDiagonal() + Q * by_inverse.asDiagonal());
        W -= vector.topRows(n_);
        solve_.solve(-1, W * next.transpose(), dB);
        W += dB * bar;
        vector.topRows(n_) = dQ;
        vector.bottomRows(n_) = W;
      }
    }
    return {};
  }

  void read(const Dense&, Dense& V) const override { V = vectors_; }

 private:
  Index n_;
  int substeps_;
  DiscreteStiefel<double> map_;
  TangentParameters parameters_;
  SymmetricSolve solve_;
  Dense vectors_;
};

std::unique_ptr<TangentMap> discrete_stiefel_tangent(const Scene& scene,
                                                     const TangentParameters& at) {
  return std::make_unique<DiscreteStiefelTangent>(scene, at);
}

constexpr MethodTangent of_stiefel[] = {{Variational::traits.name, rattle_tangent}};
constexpr MethodTangent of_discrete_stiefel[] = {{"", discrete_stiefel_tangent}};

}  // namespace

const Tangents stiefel_tangents = {cotangent_of_frames, of_stiefel};
const Tangents discrete_stiefel_tangents = {pairs_of_frames, of_discrete_stiefel};

}  // namespace stiefel
