#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "engine/frames/geodesics/anderson.h"
#include "engine/frames/geodesics/connect_work.h"
#include "engine/frames/geodesics/geodesic_search.h"
#include "engine/frames/geodesics/geodesic_series.h"
#include "engine/frames/geodesics/nodes.h"
#include "engine/frames/geodesics/relaxation.h"
#include "engine/frames/geodesics/starts.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The path of Λ^s on pieces of polynomials.
class PathOfPower {
 public:
  PathOfPower(const Posed& p, double s, std::uint64_t seed)
      : p_(p), s_(s), nodes_(pieces(VectorXd::LinSpaced(3, 0, 1), degree)) {
    relaxation_ = relaxation(nodes_);
    relaxation_->set_path(starts(p.Q_0, p.Q_T, nodes_.times, 0, seed, false)[0]);
  }

  double s() const { return s_; }
  Relaxation& relaxation() { return *relaxation_; }

  /// Moves to a larger s by Newton steps without shifts or, if they may be `shifted`, to any
  /// minimum near by. Returns false, at the old s, where they do not converge.
  bool move(double s, bool shifted) {
    constexpr double rough = 0.03;
    constexpr int most_near = 8, most = 100;
    const double before = std::exchange(s_, s);
    const Path path = relaxation_->path();
    relaxation_->set_inertia(inertia());
    if (relaxation_->relax(rough, most_near, 0)) return true;
    relaxation_->set_path(path);
    if (shifted && relaxation_->relax(rough, most)) return true;
    s_ = before;
    relaxation_->set_inertia(inertia());
    relaxation_->set_path(path);
    return false;
  }

  /// Halves pieces with a defect above `tolerance` and relaxes the path, until there are none.
  /// Returns false where that takes too many equations, or the path does not converge.
  bool resolve(double tolerance) {
    constexpr double coarse = 1e-3;
    for (;;) {
      const Path path = relaxation_->path();
      const VectorXd defect = defects(path, nodes_), &breaks = nodes_.breaks;
      if (!(defect.maxCoeff() > tolerance)) return true;
      std::vector<double> halved = {0};
      for (Index i = 0; i < defect.size(); ++i) {
        if (defect(i) > tolerance) halved.push_back((breaks(i) + breaks(i + 1)) / 2);
        halved.push_back(breaks(i + 1));
      }
      const Index ends = static_cast<Index>(halved.size()), n = p_.Q_0.rows();
      const Index equations = ((ends - 1) * degree - 1) * n * (n + 1) / 2;
      if (ends - 1 > most_pieces || equations > Relaxation::most_dense) return false;
      Nodes finer = pieces(VectorXd::Map(halved.data(), ends), degree);
      auto next = relaxation(finer);
      next->set_path(moved(path, nodes_, finer));
      if (!next->relax(coarse)) return false;
      relaxation_ = std::move(next);
      nodes_ = std::move(finer);
    }
  }

 private:
  static constexpr int degree = 8, most_pieces = 16;

  VectorXd inertia() const { return s_ < 1 ? VectorXd(p_.lambda.array().pow(s_)) : p_.lambda; }
  std::unique_ptr<Relaxation> relaxation(const Nodes& nodes) const {
    return std::make_unique<Relaxation>(inertia(), p_.Q_0, p_.Q_T, nodes);
  }

  const Posed& p_;
  double s_;
  Nodes nodes_;
  std::unique_ptr<Relaxation> relaxation_;
};

}  // namespace

Velocity corrected(const Posed& p, const Relaxation& relaxation) {
  constexpr int most = 16;
  constexpr double rounding = 3e-15, nearly = 1e-13;
  Velocity best;
  MatrixXd V = relaxation.velocity();
  VectorXd x = V.reshaped();
  Anderson accelerate(x.size(), 6);
  double start = 0;
  int idle = 0;
  for (int k = 0; k < most && idle < 3; ++k) {
    V.reshaped() = x;
    const auto end = geodesic_end(p.lambda, p.Q_0, V);
    if (!end) break;
    const MatrixXd miss = *end - p.Q_T;
    const double residual = miss.cwiseAbs().maxCoeff();
    if (k == 0) start = residual;
    if (!(residual <= 10 * start)) break;
    idle = residual > best.residual / 2 ? idle + 1 : 0;
    if (residual < best.residual) best = {V, residual};
    if (best.residual <= rounding || (best.residual <= nearly && idle > 0)) break;
    stop_point(
        connect_work::distance(20, static_cast<double>(V.rows()), static_cast<double>(V.cols())));
    accelerate(x, relaxation.response(-miss).reshaped());
  }
  const bool near =
      best.V.size() > 0 && energy(p.lambda, best.V) <= (1 + strayed) * relaxation.action() + 1e-300;
  return near ? best : Velocity();
}

Velocity by_powers(const Posed& p, const TwoPointProblem& problem) {
  constexpr double least_stride = 1.0 / 64, accurate = 1e-12, fine = 1e-5, least_tolerance = 1e-9;
  double tolerance = 1e-3;
  const double decades = std::log10(p.lambda.maxCoeff() / p.lambda.minCoeff());
  PathOfPower path(p, 1 / std::max(std::ceil(decades - 0.5), 2.0), problem.seed);
  if (!path.relaxation().relax(1e-2) || !path.resolve(tolerance)) return {};
  for (double stride = 0.125; path.s() < 1;) {
    stride = std::min(stride, 1 - path.s());
    const bool least = stride / 2 < least_stride;
    if (path.move(path.s() + stride, least)) {
      if (!path.resolve(tolerance)) return {};
      stride *= 2;
    } else if (least) {
      return {};
    } else {
      stride /= 2;
    }
  }
  Velocity best;
  for (; best.residual > accurate && tolerance > least_tolerance; tolerance /= 10) {
    if (!path.resolve(tolerance)) break;
    (void)path.relaxation().relax(fine);
    Velocity found = corrected(p, path.relaxation());
    if (found.residual < best.residual) best = std::move(found);
  }
  return best;
}

}  // namespace stiefel
