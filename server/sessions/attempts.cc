#include "server/sessions/attempts.h"

#include <algorithm>
#include <cmath>

#include "stiefel/price.h"

namespace stiefel::server {

bool chooses_steps(const Scene& scene) {
  const auto& method = scene.description().method;
  return method && method->tolerance;
}

double most_h_omega(const Scene& scene, double rate) {
  const double h = std::abs(scene.description().step.value_or(0)) / scene.substeps();
  Eigen::VectorXd lambda = scene.inertia();
  std::ranges::sort(lambda);
  const Eigen::Index N = lambda.size();
  if (N < 2) return h * rate;
  // The moments of a body with its whole attitude are λ_i + λ_j; those of a frame of fewer vectors
  // are at least the least λ.
  const bool whole = frame_size(scene).n >= static_cast<double>(N) - 1;
  const double least = lambda(0) + (whole ? lambda(1) : lambda(0));
  const double most = lambda(N - 1) + (whole ? lambda(N - 2) : lambda(N - 1));
  return h * rate * std::sqrt(most / least);
}

}  // namespace stiefel::server
