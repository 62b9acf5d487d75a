#include "engine/frame/geodesics/metric.h"

#include <cmath>

#include "engine/numbers/to_text.h"

namespace stiefel {

std::optional<refusal::Invalid> metric_fault(const Eigen::VectorXd& inertia, Eigen::Index n,
                                             Eigen::Index N) {
  using refusal::Invalid;
  if (inertia.size() != N)
    return Invalid{"inertia", std::to_string(inertia.size()) + " numbers",
                   "must have " + std::to_string(N)};
  for (Eigen::Index k = 0; k < N; ++k)
    if (!std::isfinite(inertia(k)))
      return Invalid{"inertia[" + std::to_string(k) + "]", to_text(inertia(k)), "must be finite"};
  Eigen::VectorXd sorted = inertia;
  std::partial_sort(sorted.begin(), sorted.begin() + 2, sorted.end());
  if (n < N && !(sorted(0) > 0))
    return Invalid{"inertia", "smallest " + to_text(sorted(0)), "must be positive for n < N"};
  if (n == N && !(sorted(0) + sorted(1) > 0))
    return Invalid{"inertia", "the two smallest add up to " + to_text(sorted(0) + sorted(1)),
                   "every two must have a positive sum"};
  return {};
}

}  // namespace stiefel
