#include "engine/frames/body/discrete_stiefel.h"
#include "engine/frames/body/stiefel_costate.h"
#include "engine/frames/ellipsoid_maps.h"
#include "engine/frames/passes/dual_rattle.h"
#include "engine/frames/rattle_tangent.h"
#include "engine/frames/stiefel_maps.h"
#include "engine/laws/tangent_spaces.h"
#include "engine/linalg/lie/dual_skew_flow.h"
#include "engine/stepping/tangent_map_of.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Made = std::unique_ptr<TangentMap>;
using Dense = Eigen::MatrixXd;

TangentSpace of(std::function<Dense(const Dense& x, const Dense& G)> tangent) {
  return {TangentSpace::Coordinates::orthonormal, std::move(tangent)};
}

/// QQᵀ = I, any lower block.
Dense tangent_to_costates(const Dense& x, const Dense& G) {
  Dense T = G;
  const Eigen::Index n = x.rows() / 2;
  T.topRows(n) = tangent_to_frames<double>(x.topRows(n), G.topRows(n));
  return T;
}
TangentSpace costates(const Scene&) { return of(tangent_to_costates); }

/// A scene makes S tangent: QΛ⁻¹Sᵀ + SΛ⁻¹Qᵀ = 0 for S − YQ, so that dS = −dY Q with
///
///     K dY + dY K = −(C + Cᵀ),   C = Q (dΛ/Λ²) Sᵀ,   K = QΛ⁻¹Qᵀ.
Dense frames_by_inertia(const Eigen::VectorXd& lambda, const Dense& x) {
  const Eigen::Index n = x.rows() / 2;
  const auto Q = x.topRows(n), S = x.bottomRows(n);
  SymmetricLyapunov<double> lyapunov(n);
  lyapunov.factor(Q * lambda.cwiseInverse().asDiagonal() * Q.transpose());
  Dense out = Dense::Zero(x.size(), x.cols()), dY(n, n);
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    stop_point(2 * static_cast<double>(n * Q.size()));
    const Dense C = Q.col(k) * S.col(k).transpose() / (lambda(k) * lambda(k));
    lyapunov.solve(-(C + C.transpose()), dY);
    out.col(k).reshaped(x.rows(), x.cols()).bottomRows(n) = -dY * Q;
  }
  return out;
}

Made costate_map(const Scene& scene, const TangentParameters& at) {
  return make_tangent(scene, StiefelCostate<Tangent>(at.lambda, scene.Q().rows()), at.h);
}

}  // namespace

Tangents stiefel_tangents() {
  return {[](const Scene& scene) {
            const CotangentOfFrames<double> frames{scene.inertia()};
            TangentSpace space =
                of([frames](const Dense& x, const Dense& G) { return frames.tangent(x, G); });
            space.tangent_of_every_inertia = tangent_to_costates;
            space.by_inertia = [lambda = frames.lambda](const Dense& x) {
              return frames_by_inertia(lambda, x);
            };
            return space;
          },
          [](const Scene& scene, const TangentParameters& at) {
            return make_tangent(scene, Stiefel<Tangent>(at.lambda, scene.Q().rows()), at.h);
          },
          has_rattle_tangent, rattle_tangent};
}

Tangents stiefel_costate_tangents() { return {costates, costate_map}; }
/// The state is that of the costate P_0.
Tangents stiefel_momentum_tangents() {
  return {[](const Scene&) {
            return of([](const Dense& x, const Dense& G) {
              return CostatesOfFrames<double>().tangent(x, G);
            });
          },
          costate_map};
}

Tangents ellipsoid_tangents() {
  return {[](const Scene& scene) {
            if (scene.block("p").size() > 0) return costates(scene);
            const CotangentOfFrames<double> space{Eigen::VectorXd::Ones(scene.dimension())};
            return of([space](const Dense& x, const Dense& G) { return space.tangent(x, G); });
          },
          [](const Scene& scene, const TangentParameters& at) {
            return scene.block("p").size() > 0
                       ? make_tangent(scene, EllipsoidCostate<Tangent>(at.lambda), at.h)
                       : make_tangent(scene, Ellipsoid<Tangent>(at.lambda), at.h);
          }};
}

Tangents discrete_stiefel_tangents() {
  return {[](const Scene&) {
            return of([](const Dense& x, const Dense& G) {
              const Eigen::Index n = x.rows() / 2;
              return stacked_pair<double>(
                  tangent_to_frames<double>(x.topRows(n), G.topRows(n)),
                  tangent_to_frames<double>(x.bottomRows(n), G.bottomRows(n)));
            });
          },
          [](const Scene& scene, const TangentParameters& at) -> Made {
            return std::make_unique<TangentMapOf<DiscreteStiefel<Tangent>>>(
                [&] { return DiscreteStiefel<Tangent>(at.lambda, scene.Q().rows()); },
                scene.substeps());
          }};
}

}  // namespace stiefel
