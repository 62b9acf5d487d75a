#include "engine/rigid_body/tangents/dual_body_tangents.h"

#include "engine/linalg/lie/dual_skew_flow.h"
#include "engine/linalg/lie/general_exponential.h"
#include "engine/rigid_body/exact/euler_top.h"
#include "engine/rigid_body/exact/two_valued_body.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {
namespace {

using Wide = long double;
using Vec = Vector3<Wide>;
using Coordinates = Eigen::Matrix<Wide, 6, TangentMap::lanes>;

/// With ω = m/I, the coordinates (η, δm) obey a linear equation with constant coefficients,
///
///     η̇ = −ω × η + I⁻¹δm + δ_Iω,   δṁ = δm × ω + m × (I⁻¹δm + δ_Iω),   δ_Iω = −m/I² δI,
///
/// which one matrix exponential solves, the terms of δ_Iω as further columns; the derivative by t
/// is (ω, 0).
class SteadyTangent final : public TangentMap {
 public:
  SteadyTangent(const TangentParameters& at, Vec m, int substeps)
      : step_(static_cast<Wide>(at.h.value) * substeps), omega_(Vec::Zero()), frame_(false) {
    const Vector3<double> lambda = values_of(at.lambda);
    const Vec I = PrincipalMoments3<Wide>(lambda).moments;
    omega_ = m.cwiseQuotient(I);
    const Vec inverse = I.cwiseInverse();
    A_.setZero(6 + lanes, 6 + lanes);
    A_.block<3, 3>(0, 0) = -hat(omega_);
    A_.block<3, 3>(0, 3) = inverse.asDiagonal();
    A_.block<3, 3>(3, 3) = hat(m) * inverse.asDiagonal().toDenseMatrix() - hat(omega_);
    for (int k = 0; k < lanes; ++k) {
      const Vector3<double> d = lane_of(at.lambda, k);
      const Vec dI = PrincipalMoments3<Wide>(d).moments;
      const Vec domega = -omega_.cwiseProduct(inverse).cwiseProduct(dI);
      A_.block<3, 1>(0, 6 + k) = domega;
      A_.block<3, 1>(3, 6 + k) = m.cross(domega);
      by_step_[k] = static_cast<Wide>(at.h.d[k]) * substeps;
    }
  }

  void start(const Eigen::MatrixXd& point, const Eigen::MatrixXd& V) override {
    start_.setZero();
    frame_ = point.rows() == 7;
    for (Eigen::Index k = 0; k < V.cols(); ++k) {
      const Eigen::MatrixXd blocks = V.col(k).reshaped(V.rows() / 3, 3);
      start_.block<3, 1>(3, k) = vee(blocks.bottomRows(3)).cast<Wide>();
      if (!frame_) continue;
      const Eigen::Matrix3d eta =
          rotation_matrix<double>(Eigen::Vector4d(point.topRows(4))).transpose() *
          blocks.topRows(3);
      start_.block<3, 1>(0, k) = vee(((eta - eta.transpose()) / 2).eval()).cast<Wide>();
    }
    now_ = start_;
  }

  RunStatus step(const Eigen::MatrixXd&) override {
    return {Outcome::solver_stalled, std::nullopt};
  }
  bool direct() const override { return true; }
  RunStatus at(std::int64_t k) override {
    const auto steps = static_cast<Wide>(k);
    GeneralExponential<Wide> exponential(A_.rows());
    Matrix<Wide> D(A_.rows(), A_.cols());
    exponential(steps * step_ * A_, D);
    if (!D.allFinite()) return {Outcome::not_finite, std::nullopt};
    now_ = start_ + D.topLeftCorner(6, 6) * start_ + D.topRightCorner(6, lanes);
    for (int lane = 0; lane < lanes; ++lane)
      now_.block<3, 1>(0, lane) += steps * by_step_[lane] * omega_;
    return {};
  }

  void read(const Eigen::MatrixXd& point, Eigen::MatrixXd& V) const override {
    for (Eigen::Index k = 0; k < V.cols(); ++k) {
      Eigen::MatrixXd blocks(V.rows() / 3, 3);
      blocks.bottomRows(3) = hat(now_.block<3, 1>(3, k).eval()).cast<double>();
      if (frame_)
        blocks.topRows(3) = rotation_matrix<double>(Eigen::Vector4d(point.topRows(4))) *
                            hat(now_.block<3, 1>(0, k).eval()).cast<double>();
      V.col(k) = blocks.reshaped();
    }
  }

 private:
  Wide step_;
  Vec omega_;
  Matrix<Wide> A_;
  Wide by_step_[lanes];
  Coordinates start_, now_;
  bool frame_;
};

/// Whether m × ω = 0. EulerTop has a formula of its own for these motions, whose derivative is not
/// that of the motions beside them.
bool is_steady(const Scene& scene) {
  const Eigen::Vector3d m = vee(scene.M()), lambda = scene.inertia();
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    if (m(b) != 0 && m(c) != 0 && lambda(b) != lambda(c)) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<TangentMap> exact_body_tangent(const Scene& scene, const TangentParameters& at) {
  if (scene.dimension() != 3) return body_tangent_by<SoN<Tangent>, Exact>(scene, at);
  if (is_steady(scene))
    return std::make_unique<SteadyTangent>(at, vee(scene.M()).cast<Wide>(), scene.substeps());
  return body_tangent_by<So3<Tangent, true>, Exact>(scene, at);
}

}  // namespace stiefel
