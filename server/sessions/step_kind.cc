#include "server/sessions/step_kind.h"

#include <algorithm>
#include <cmath>

#include "server/scheduling/slice.h"
#include "stiefel/price.h"

namespace stiefel::server {
namespace {

/// Whether the method iterates; assumed of one that is not in the table of prices.
bool iterates(const Scene& scene) { return !is_weighed(scene) || price_depends_on_rate(scene); }

}  // namespace

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

bool kind_depends_on_rate(const Scene& scene, double step_cost) {
  return kind_of_steps(step_cost) != JobKind::unsliced && (chooses_steps(scene) || iterates(scene));
}

StepKind step_kind(const Scene& scene, double step_cost, double h_omega) {
  const bool chooses = chooses_steps(scene);
  StepKind out{kind_of_steps(step_cost), chooses};
  if (!kind_depends_on_rate(scene, step_cost)) return out;
  if (!(h_omega <= 1)) return {JobKind::unsliced, true};
  if (chooses) out.kind = std::max(out.kind, JobKind::sliced);
  return out;
}

}  // namespace stiefel::server
