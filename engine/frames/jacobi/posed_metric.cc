#include "engine/frames/jacobi/posed_metric.h"

#include <algorithm>
#include <cmath>

#include "engine/numbers/to_text.h"

namespace stiefel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

PosedMetric::PosedMetric(const VectorXd& inertia)
    : scale_(std::exp2(2 * std::floor(std::ilogb(inertia.cwiseAbs().maxCoeff()) / 2.0))) {
  lambda_ = inertia / scale_;
}

double PosedMetric::norm(const MatrixXd& V) const {
  return std::sqrt((V.cwiseAbs2() * lambda_).sum());
}

MatrixXd PosedMetric::tangent(const MatrixXd& Q, const MatrixXd& V) {
  const MatrixXd half = V * Q.transpose();
  return V - (half + half.transpose()) / 2 * Q;
}

std::optional<refusal::Invalid> metric_fault(const VectorXd& inertia, Index n, Index N,
                                             Index most_degrees) {
  using refusal::Invalid;
  if (inertia.size() != N)
    return Invalid{"inertia", std::to_string(inertia.size()) + " numbers",
                   "must have " + std::to_string(N)};
  for (Index k = 0; k < N; ++k)
    if (!std::isfinite(inertia(k)))
      return Invalid{"inertia[" + std::to_string(k) + "]", to_text(inertia(k)), "must be finite"};
  VectorXd sorted = inertia;
  std::sort(sorted.begin(), sorted.end());
  if (n < N && !(sorted(0) > 0))
    return Invalid{"inertia", "smallest " + to_text(sorted(0)), "must be positive for n < N"};
  if (n == N && !(sorted(0) + sorted(1) > 0))
    return Invalid{"inertia", "the two smallest add up to " + to_text(sorted(0) + sorted(1)),
                   "every two must have a positive sum"};
  const Index d = n * N - n * (n + 1) / 2;
  if (d > most_degrees)
    return Invalid{"Q", std::to_string(n) + " x " + std::to_string(N),
                   "must have at most " + std::to_string(most_degrees) +
                       " degrees of freedom, nN - n(n + 1)/2, and has " + std::to_string(d)};
  return {};
}

}  // namespace stiefel
