#include "engine/body/exact/euler_top.h"
#include "engine/body/rigid_tangents.h"
#include "engine/dense/decompositions.h"
#include "engine/motion/body_view.h"
#include "engine/numbers/dual.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Wide = long double;
using Vec = Vector3<Wide>;
using Columns = Eigen::Matrix<Wide, 6, Eigen::Dynamic>;

/// The columns (η, δm) of vectors, which are blocks, at a point (q; m) or m, and back.
Columns columns_of(const Dense& point, const Dense& V) {
  Columns x = Columns::Zero(6, V.cols());
  for (Index k = 0; k < V.cols(); ++k) {
    const Dense blocks = in_body(point, V.col(k));
    x.block<3, 1>(3, k) = vee(blocks.bottomRows(3)).cast<Wide>();
    if (blocks.rows() > 3) x.block<3, 1>(0, k) = vee(blocks.topRows(3)).cast<Wide>();
  }
  return x;
}
void write(const Columns& x, const Dense& point, Dense& V) {
  for (Index k = 0; k < V.cols(); ++k) {
    Dense blocks(V.rows() / 3, 3);
    blocks.topRows(3) = hat(x.block<3, 1>(0, k)).cast<double>();
    blocks.bottomRows(3) = hat(x.block<3, 1>(3, k)).cast<double>();
    V.col(k) = in_space(point, blocks);
  }
}

/// Tangents of the closed form, which move from the start by any number of steps.
class ExactBodyTangent : public TangentMap {
 public:
  ExactBodyTangent(const Scene& scene, const TangentParameters& at)
      : parameters_(at), substeps_(scene.substeps()) {}

  RunStatus step(const Dense&) override { return {Outcome::solver_stalled, std::nullopt}; }
  bool direct() const override { return true; }
  void read(const Dense& point, Dense& V) const override { write(now_, point, V); }

 protected:
  TangentParameters parameters_;
  int substeps_;
  Columns now_;
};

/// With ω = m/I, the coordinates (η, δm) obey a linear equation with constant coefficients,
///
///     η̇ = −ω × η + I⁻¹δm + δ_Iω,   δṁ = δm × ω + m × (I⁻¹δm + δ_Iω),   δ_Iω = −m/I² δI,
///
/// which one matrix exponential solves, the terms of δ_Iω as further columns; the derivative by t
/// is (ω, 0).
class SteadyTangent final : public ExactBodyTangent {
 public:
  using ExactBodyTangent::ExactBodyTangent;

  void start(const Dense& point, const Dense& V) override {
    now_ = start_ = columns_of(point, V);
    const Vec m = Eigen::Vector3d(point.bottomRows(3)).cast<Wide>();
    const Vector3<double> lambda = parameters_.lambda;
    const Vec inverse = PrincipalMoments3<Wide>(lambda).moments.cwiseInverse();
    omega_ = m.cwiseProduct(inverse);
    A_.setZero(6 + V.cols(), 6 + V.cols());
    A_.block<3, 3>(0, 0) = -hat(omega_);
    A_.block<3, 3>(0, 3) = inverse.asDiagonal();
    A_.block<3, 3>(3, 3) = hat(m) * inverse.asDiagonal().toDenseMatrix() - hat(omega_);
    for (Index k = 0; k < V.cols(); ++k) {
      const Vector3<double> d = parameters_.by_lambda.col(k);
      const Vec domega =
          -omega_.cwiseProduct(inverse).cwiseProduct(PrincipalMoments3<Wide>(d).moments);
      A_.block<3, 1>(0, 6 + k) = domega;
      A_.block<3, 1>(3, 6 + k) = m.cross(domega);
    }
  }

  RunStatus at(std::int64_t k) override {
    const Wide steps = static_cast<Wide>(k) * substeps_;
    Exponential<Wide> exponential(A_.rows(), MatrixKind::general);
    Matrix<Wide> D(A_.rows(), A_.cols());
    exponential(steps * static_cast<Wide>(parameters_.h) * A_, D);
    if (!D.allFinite()) return {Outcome::not_finite, std::nullopt};
    now_ = start_ + D.topLeftCorner(6, 6) * start_ + D.topRightCorner(6, start_.cols());
    now_.topRows(3) += steps * omega_ * parameters_.by_h.transpose().cast<Wide>();
    return {};
  }

 private:
  Vec omega_;
  Matrix<Wide> A_;
  Columns start_;
};

/// Euler's and Jacobi's solution in dual numbers, some vectors in each.
class MovingTangent final : public ExactBodyTangent {
 public:
  using ExactBodyTangent::ExactBodyTangent;

  void start(const Dense& point, const Dense& V) override {
    now_ = columns_of(point, V);
    motions_.clear();
    for (Index first = 0; first < V.cols(); first += lanes) {
      stop_point();
      Motion::Point x = Motion::Point::Zero();
      x(0) = 1;
      const Index above = 7 - point.size();
      for (Index i = above; i < 7; ++i) x(i) = point(i - above);
      const Eigen::Matrix<Wide, 4, 1> q = values_of(x).head<4>();
      Vector3<Number> lambda = parameters_.lambda.cast<Number>();
      Number h = parameters_.h;
      for (Index k = first; k < std::min(first + lanes, V.cols()); ++k) {
        const auto lane = static_cast<int>(k - first);
        const Eigen::Matrix<Wide, 4, 1> dq =
            So3<Wide, true>::quaternion_times(q, Wide(0), Vec(now_.block<3, 1>(0, k) / 2));
        for (int i = 0; i < 4; ++i) x(i).d[lane] = dq(i);
        for (int i = 0; i < 3; ++i) x(4 + i).d[lane] = now_(3 + i, k);
        for (int i = 0; i < 3; ++i) lambda(i).d[lane] = parameters_.by_lambda(i, k);
        h.d[lane] = parameters_.by_h(k);
      }
      motions_.push_back({Motion(PrincipalMoments3<Number>(lambda), x), h});
    }
  }

  RunStatus at(std::int64_t k) override {
    for (std::size_t i = 0; i < motions_.size(); ++i) {
      stop_point();
      const auto& [motion, h] = motions_[i];
      const Motion::Point x = motion.at(static_cast<Wide>(k) * substeps_ * h);
      // δq = ½q∘(0, η): η = 2 q*∘δq
      Eigen::Matrix<Wide, 4, 1> back = values_of(x).head<4>();
      back.tail<3>() *= -1;
      const Index first = static_cast<Index>(i) * lanes;
      for (Index v = first; v < std::min(first + lanes, now_.cols()); ++v) {
        const Eigen::Matrix<Wide, 7, 1> dx = lane_of(x, static_cast<int>(v - first));
        now_.block<3, 1>(0, v) =
            2 * So3<Wide, true>::quaternion_times(back, dx(0), dx.segment<3>(1)).tail<3>();
        now_.block<3, 1>(3, v) = dx.tail<3>();
      }
      if (!now_.allFinite()) return {Outcome::not_finite, std::nullopt};
    }
    return {};
  }

 private:
  static constexpr int lanes = 4;
  using Number = Dual<Wide, lanes>;
  using Motion = EulerTop<Number>;

  std::vector<std::pair<Motion, Number>> motions_;  ///< with the step
};

/// Whether m × ω = 0. EulerTop has a formula of its own for these motions, whose derivative is not
/// that of the motions beside them.
bool is_steady(const Scene& scene) {
  const Eigen::Vector3d m = vee(body_momentum(scene)), lambda = scene.inertia();
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    if (m(b) != 0 && m(c) != 0 && lambda(b) != lambda(c)) return false;
  }
  return true;
}

}  // namespace

std::unique_ptr<TangentMap> exact_body_tangent(const Scene& scene, const TangentParameters& at) {
  if (is_steady(scene)) return std::make_unique<SteadyTangent>(scene, at);
  return std::make_unique<MovingTangent>(scene, at);
}

}  // namespace stiefel
