#include "engine/frame/discrete_stiefel.h"
#include "engine/dense/orthogonal.h"
#include "engine/frame/stiefel_forms.h"
#include "engine/frame/stiefel_invariants.h"
#include "engine/motion/make_simulation.h"
#include "engine/motion/tangent_map.h"
#include "engine/structure/tangent_spaces.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

void check_discrete(SceneDraft& draft) {
  if (!check_stiefel_frame(draft)) return;
  const auto& Q = draft.scene().Q();
  if (const RowMatrix* Q_prev = draft.block("Q_prev", Q.rows(), Q.cols()))
    draft.set_frame("Q_prev", *Q_prev);
}

// For n = N (55) is the map of Moser and Veselov. For n < N it is a motion of its own, which has no
// other form.

OutsideDomain not_square(const Eigen::MatrixXd& Q) {
  return {"n = N", static_cast<double>(Q.rows()), static_cast<double>(Q.cols())};
}

WithinDomain<Phase> read_discrete(const Scene& scene, Margins& margins) {
  const Eigen::MatrixXd& Q = scene.Q();
  if (Q.rows() != Q.cols()) return outside(not_square(Q), "initial.Q");
  return representations::moser_veselov_pair.read(scene, margins);
}
WithinDomain<FormBlocks> write_discrete(const Phase& x, const ConversionTarget& target,
                                        Margins& margins) {
  if (!x.square()) return outside(not_square(x.Q), "to");
  return representations::moser_veselov_pair.write(x, target, margins);
}
constexpr Representation discrete_representation = {false, read_discrete, write_discrete};

std::unique_ptr<Simulation> make_discrete_stiefel(const Scene& scene) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  const int rows = static_cast<int>(n);
  const Eigen::VectorXd lambda = scene.inertia();
  Observables observables(stacked(scene, "Q_prev", "Q"));
  observables.block("Q_prev", 0, rows).block("Q", rows, rows);
  observables.all_invariants = [=](const Eigen::MatrixXd& x, InvariantList& out) {
    using Wide = long double;
    const Matrix<Wide> Q_prev = x.topRows(n).cast<Wide>(), Q = x.bottomRows(n).cast<Wide>();
    const Vector<Wide> wide_lambda = lambda.cast<Wide>();
    if (out.wants(family::spatial_momentum))
      out.add_skew(family::spatial_momentum, discrete_momentum<Wide>(wide_lambda, Q_prev, Q),
                   wide_lambda.maxCoeff());
    if (!out.wants(family::lax, N <= largest_lax_unasked)) return;
    out.add_coefficients(
        family::lax, discrete_lax_coefficients<Wide>(wide_lambda, Q_prev, Q, static_cast<int>(N)));
  };
  observables.frame_defect = [n](const Eigen::MatrixXd& x) {
    return std::optional(orthogonality_defect(x.bottomRows(n)));
  };
  observables.speed = [=, h = scene.step()](const Eigen::MatrixXd& x) {
    return (x.bottomRows(n) - x.topRows(n)).norm() / std::abs(h);
  };
  using Map = DiscreteStiefel<double>;
  return std::make_unique<SimulationOf<Map>>(scene, Map(lambda, n), shared(observables));
}

/// Two frames.
TangentSpace pairs_of_frames(const Scene&) { return {tangent_to_pairs<double>}; }

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
        lyapunov_(n_) {}

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
      lyapunov_.factor(bar * next.transpose());
      Dense dB(n_, n_);
      for (Index v = 0; v < vectors_.cols(); ++v) {
        stop_point(3 * static_cast<double>(n_ * Q.size()));
        auto vector = vectors_.col(v).reshaped(2 * n_, Q.cols());
        const Dense dQ = vector.bottomRows(n_);
        const Eigen::VectorXd by_inverse =
            -parameters_.by_lambda.col(v).array() * inverse.array().square();
        Dense W = B * (dQ * inverse.asDiagonal() + Q * by_inverse.asDiagonal());
        W -= vector.topRows(n_);
        dB = -W * next.transpose();
        dB += dB.transpose().eval();
        lyapunov_.solve(dB, dB);
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
  Lyapunov<double> lyapunov_;
  Dense vectors_;
};

std::unique_ptr<TangentMap> discrete_stiefel_tangent(const Scene& scene,
                                                     const TangentParameters& at) {
  return std::make_unique<DiscreteStiefelTangent>(scene, at);
}

constexpr MethodTangent tangent_of_map[] = {{"", discrete_stiefel_tangent}};
constexpr Tangents discrete_tangents = {pairs_of_frames, tangent_of_map};

}  // namespace

SystemEntry discrete_stiefel_entry() {
  SystemInfo info{};
  info.blocks = {{"Q_prev", "n x N", true, "frame one step before, orthonormal rows"},
                 {"Q", "n x N", true, "frame, orthonormal rows"}};
  info.fields = {{"Q_prev", "n x N", "frame one step before"},
                 {"Q", "n x N", "frame, orthonormal rows"}};
  info.invariants = {
      {family::spatial_momentum, "Q Lambda Q_prev^T - Q_prev Lambda Q^T, n x n", "[ST] (57)"},
      {family::lax,
       "coefficients of mu^j in tr L(mu)^k, "
       "L(mu) = Lambda^2 + mu (Q_prev^T Q Lambda - Lambda Q^T Q_prev) - mu^2 Q_prev^T Q_prev",
       "[ST] (61)"},
      {family::orthogonality, "Q Q^T = I", ""},
  };
  info.name = "discrete_stiefel";
  info.summary =
      "discrete variational problem of Moser and Veselov on V(n, N); for n < N an integrable map "
      "of its own (n = 1: the discrete Neumann system), NOT a discretisation of the geodesic "
      "flow: after ten steps from a geodesic it is off by 0.3 to 1, at h = 0.2, 0.02 and 0.002 "
      "alike";
  info.equations = "Q_{k+1} Lambda + Q_{k-1} Lambda = B_k Q_k, B_k symmetric";
  info.source = "[ST] (55)";
  info.file = "engine/frame/discrete_stiefel.h";
  info.discrete = true;
  return {.info = info,
          .check = check_discrete,
          .make = make_discrete_stiefel,
          .methods = keeps_all,
          .representation = &discrete_representation,
          .tangents = &discrete_tangents};
}

}  // namespace stiefel
