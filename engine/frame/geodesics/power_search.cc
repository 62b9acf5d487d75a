#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "engine/dense/anderson.h"
#include "engine/dense/continuation.h"
#include "engine/frame/geodesics/connect_work.h"
#include "engine/frame/geodesics/geodesic_search.h"
#include "engine/frame/geodesics/geodesic_series.h"
#include "engine/frame/geodesics/nodes.h"
#include "engine/frame/geodesics/relaxation.h"
#include "engine/frame/geodesics/starts.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A path on pieces of polynomials of one degree, which are halved where they do not resolve it.
class Pieces {
 public:
  explicit Pieces(const Posed& p) : p_(p), nodes_(pieces(VectorXd::LinSpaced(3, 0, 1), degree)) {}

  const Nodes& nodes() const { return nodes_; }

  /// Halves pieces with a defect above `tolerance` and relaxes the path, until there are none.
  /// Returns false where that takes too many equations, or the path does not converge.
  bool resolve(std::unique_ptr<Relaxation>& relaxation, double tolerance) {
    constexpr double coarse = 1e-3;
    for (;;) {
      const Path path = relaxation->path();
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
      auto next = std::make_unique<Relaxation>(relaxation->inertia(), p_.Q_0, p_.Q_T, finer);
      next->set_path(moved(path, nodes_, finer));
      if (!next->relax(coarse)) return false;
      relaxation = std::move(next);
      nodes_ = std::move(finer);
    }
  }

 private:
  static constexpr int degree = 8, most_pieces = 16;

  const Posed& p_;
  Nodes nodes_;
};

/// Returns the frames nearest to a + factor (a − b).
Path extrapolated(const Path& a, const Path& b, double factor) {
  Path out = a;
  for (std::size_t k = 1; k + 1 < a.size(); ++k) {
    stop_point(connect_work::frame(a[0].rows(), a[0].cols()));
    out[k] = polar(a[k] + factor * (a[k] - b[k]));
  }
  return out;
}

}  // namespace

Velocity corrected(const Posed& p, const Relaxation& relaxation) {
  constexpr int most = 16;
  constexpr double rounding = 3e-15, nearly = 1e-13;
  Velocity best;
  MatrixXd V = relaxation.velocity();
  VectorXd x = V.reshaped();
  Anderson accelerate(x.size(), 1, 6);
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
    stop_point(connect_work::sums(20, V.rows(), V.cols()));
    accelerate(x, relaxation.response(-miss).reshaped());
  }
  const bool near =
      best.V.size() > 0 && energy(p.lambda, best.V) <= (1 + strayed) * relaxation.action() + 1e-300;
  return near ? best : Velocity();
}

bool follow_powers(const VectorXd& lambda, std::unique_ptr<Relaxation>& relaxation,
                   const std::function<bool()>& resolve) {
  constexpr double rough = 0.03, coarse = 1e-3, least_stride = 1.0 / 32,
                   unlimited = std::numeric_limits<double>::infinity();
  constexpr int most_near = 8;
  const auto power = [&](double s) { return s < 1 ? VectorXd(lambda.array().pow(s)) : lambda; };
  const double decades = std::log10(lambda.maxCoeff() / lambda.minCoeff());
  bool resolved = true;
  double now = 1;
  for (int k = static_cast<int>(std::ceil(decades - 0.5)); k > 1 && resolved; --k) {
    relaxation->set_inertia(power(now = 1.0 / k));
    (void)relaxation->relax(rough);
    resolved = resolve();
  }
  if (now == 1) return relaxation->relax(coarse) && resolve();
  double earlier = 0;
  Path before;  // at `earlier`, where the nodes are still the same
  const auto moved_to = [&](double s) {
    if (!resolved) return false;
    const double tolerance = s < 1 ? rough : coarse;
    Path path = relaxation->path();
    relaxation->set_inertia(power(s));
    if (before.size() == path.size())
      relaxation->set_path(extrapolated(path, before, (s - now) / (now - earlier)));
    bool found = relaxation->relax(tolerance, most_near, 0);
    if (!found) {
      relaxation->set_path(path);
      found = s - now <= least_stride && relaxation->relax(tolerance);
    }
    if (found) {
      earlier = std::exchange(now, s);
      before = std::move(path);
      return resolved = resolve();
    }
    relaxation->set_inertia(power(now));
    relaxation->set_path(path);
    return false;
  };
  return continuation(1, moved_to, unlimited, now, least_stride) == 1;
}

Velocity by_powers(const Posed& p, const TwoPointProblem& problem) {
  constexpr double accurate = 1e-12, fine = 1e-5, least_tolerance = 1e-9;
  double tolerance = 1e-3;
  Pieces pieces(p);
  auto relaxation = std::make_unique<Relaxation>(p.lambda, p.Q_0, p.Q_T, pieces.nodes());
  relaxation->set_path(starts(p.Q_0, p.Q_T, pieces.nodes().times, 0, problem.seed, false)[0]);
  const auto resolve = [&] { return pieces.resolve(relaxation, tolerance); };
  if (!follow_powers(p.lambda, relaxation, resolve)) return {};
  Velocity best;
  for (; best.residual > accurate && tolerance > least_tolerance; tolerance /= 10) {
    if (!resolve()) break;
    (void)relaxation->relax(fine);
    Velocity found = corrected(p, *relaxation);
    if (found.residual < best.residual) best = std::move(found);
  }
  return best;
}

}  // namespace stiefel
