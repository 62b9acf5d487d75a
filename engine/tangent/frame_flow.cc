#include "engine/tangent/frame_flow.h"

#include <algorithm>

#include "engine/linalg/lie/exponential.h"
#include "engine/methods/munthe_kaas4.h"

namespace stiefel {

using Dense = Eigen::MatrixXd;

/// Ḟ = F·ξ along a motion. A state is F over a row with the time in units of h, an element of the
/// algebra a skew D × D matrix over a row with its rate.
struct FrameFlow::Flow {
  Flow(MatrixSystem<Tangent> system, Eigen::VectorXd by, Eigen::Index k)
      : field(std::move(system)),
        weights(std::move(by)),
        AW(weights.size(), k),
        exponential(weights.size()),
        D(weights.size(), weights.size()) {}

  void velocity(const Dense& y, Dense& xi);
  void displacement(const Dense& y, const Dense& theta, Dense& dy) {
    const Eigen::Index k = y.rows() - 1;
    exponential(theta.topRows(D.rows()), D);
    dy.topRows(k).noalias() = y.topRows(k) * D;
    dy.bottomRows(1) = theta.bottomRows(1);
  }

  MatrixSystem<Tangent> field;
  Eigen::VectorXd weights;
  const std::array<Dense, 3>* x = nullptr;
  double h = 0;
  Dense AW;
  SkewExponential<double> exponential;
  Dense D;
  std::array<Dense, 4> T;  ///< of the stages
  std::size_t stage = 0;
};

void FrameFlow::Flow::velocity(const Dense& y, Dense& xi) {
  constexpr Eigen::Index lanes = TangentMap::lanes;
  const Eigen::Index k = y.rows() - 1, size = weights.size();
  const auto F = y.topRows(k);
  const Dense& at = (*x)[static_cast<std::size_t>(std::clamp(std::lround(y(k, 0)), 0L, 2L))];
  Matrix<Tangent> point = at.cast<Tangent>(), rate = point;
  for (Eigen::Index first = 0; first < k; first += lanes) {
    const Eigen::Index width = std::min(lanes, k - first);
    for (Eigen::Index i = 0; i < size; ++i)
      for (Eigen::Index lane = 0; lane < width; ++lane)
        point(i).d[lane] = F(first + lane, i) / weights(i);
    field.field(point, rate);
    for (Eigen::Index i = 0; i < size; ++i)
      for (Eigen::Index lane = 0; lane < width; ++lane)
        AW(i, first + lane) = rate(i).d[lane] * weights(i);
  }
  const Dense C = F * AW;
  Dense& triangle = T[stage++ % T.size()];
  triangle = C.triangularView<Eigen::Upper>();
  triangle.triangularView<Eigen::StrictlyUpper>() += C.transpose();
  const Dense W_dot = AW - F.transpose() * triangle;
  const Dense skew = F * W_dot;
  const Dense outer = W_dot * F;
  xi.topRows(size) = outer.transpose() - outer - F.transpose() * skew.transpose() * F;
  xi.bottomRows(1).setZero();
  xi(size, 0) = 1 / h;
}

namespace {

/// The flow as a LieSystem, whose copies share it.
template <class Flow>
struct SystemOf {
  static constexpr const char* name = "frame_flow";
  using Scalar = double;
  using State = Dense;
  using Algebra = Dense;

  Flow* flow;

  void field(const Dense& y, Dense& dy) {
    Dense xi = zero();
    flow->velocity(y, xi);
    flow->displacement(y, xi, dy);
  }
  Dense zero() const { return Dense::Zero(flow->weights.size() + 1, flow->weights.size()); }
  void generator(const Dense& y, Dense& xi) { flow->velocity(y, xi); }
  void bracket(const Dense& a, const Dense& b, Dense& c) const {
    const Eigen::Index size = a.cols();
    const Dense ab = a.topRows(size) * b.topRows(size);
    c.topRows(size) = ab - ab.transpose();
    c.bottomRows(1).setZero();
  }
  void displacement(const Dense& y, const Dense& theta, Dense& dy) {
    flow->displacement(y, theta, dy);
  }
};

}  // namespace

FrameFlow::FrameFlow(MatrixSystem<Tangent> field, Eigen::VectorXd weights, Eigen::Index k)
    : flow_(std::make_unique<Flow>(std::move(field), std::move(weights), k)) {}
FrameFlow::~FrameFlow() = default;
FrameFlow::FrameFlow(FrameFlow&&) noexcept = default;
FrameFlow& FrameFlow::operator=(FrameFlow&&) noexcept = default;

void FrameFlow::set_weights(const Eigen::VectorXd& weights) { flow_->weights = weights; }

Dense FrameFlow::move(Dense& V, const std::array<Dense, 3>& x, double h) {
  using System = SystemOf<Flow>;
  const Eigen::Index k = V.cols(), size = V.rows();
  flow_->x = &x;
  flow_->h = h;
  flow_->stage = 0;
  MuntheKaas4::Map<System> map(System{flow_.get()}, 2 * h, {0, Arithmetic::plain});
  Dense y = Dense::Zero(k + 1, size), dy = y;
  y.topRows(k) = (flow_->weights.asDiagonal() * V).transpose();
  map.displacement(y, dy);
  y += dy;
  V = flow_->weights.cwiseInverse().asDiagonal() * y.topRows(k).transpose();

  const auto& T = flow_->T;
  const Dense I = Dense::Identity(k, k);
  const Dense a = T[0], b = T[1] * (I + h * a), c = T[2] * (I + h * b), d = T[3] * (I + 2 * h * c);
  return I + (h / 3) * (a + 2 * (b + c) + d);
}

}  // namespace stiefel
