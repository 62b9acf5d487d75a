#include "engine/simulation/catalogue/methods/recommendation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/simulation/catalogue/methods/method_traits.h"
#include "engine/simulation/catalogue/system_entry.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

constexpr double most_substeps = 1e6;

/// (‖M̈‖/‖M‖)^{1/2} of a rigid body; with M and Λ scaled to 1, so that no square overflows.
double momentum_rate(const Scene& scene) {
  const double size = scene.M().cwiseAbs().maxCoeff(), inertia = scene.inertia().maxCoeff();
  if (size == 0) return 0;
  const Eigen::VectorXd lambda = scene.inertia() / inertia;
  const Eigen::MatrixXd M = scene.M() / size, L = lambda.replicate(1, lambda.size());
  const Eigen::MatrixXd sums = L + L.transpose(), Omega = M.cwiseQuotient(sums);
  const Eigen::MatrixXd dM = M * Omega - Omega * M, dOmega = dM.cwiseQuotient(sums);
  const Eigen::MatrixXd ddM = dM * Omega + M * dOmega - dOmega * M - Omega * dM;
  return size / inertia * std::sqrt(ddM.norm() / M.norm());
}

/// For a system without a recommendation: the adaptive method, else the last method that takes
/// every scene.
Recommendation by_default(const SystemInfo& system) {
  const MethodTraits* chosen = nullptr;
  for (const MethodOnSystem& on : system.methods) {
    const MethodTraits* traits = method_traits(on.method);
    if (on.takes || (chosen && chosen->default_tolerance > 0)) continue;
    chosen = traits;
  }
  if (chosen == nullptr)
    throw std::logic_error(std::string(system.name) + " has no method that takes every scene");
  return {.method = chosen->name,
          .order = chosen->default_order,
          .arithmetic = "compensated",
          .tolerance = chosen->default_tolerance};
}

}  // namespace

MethodDescription Recommendation::description() const {
  MethodDescription out{std::string(method), std::nullopt, 1, std::string(arithmetic)};
  if (order > 0) out.order = order;
  if (tolerance > 0) out.tolerance = tolerance;
  return out;
}

int Recommendation::substeps(const Scene& scene) const {
  stop_point();
  const double h = std::abs(scene.step());
  double needed = 1;
  if (largest_h_omega > 0)
    needed = std::max(needed, std::ceil(h * system_entry(scene.system())->make(scene)->rate() /
                                        largest_h_omega));
  if (largest_h_momentum_rate > 0)
    needed = std::max(needed, std::ceil(h * momentum_rate(scene) / largest_h_momentum_rate));
  return static_cast<int>(std::min(needed, most_substeps));
}

std::vector<Recommendation> recommended(std::string_view system) {
  const SystemEntry* entry = system_entry(system);
  if (entry == nullptr || entry->info.discrete) return {};
  if (entry->recommended.empty()) return {by_default(entry->info)};
  return {entry->recommended.begin(), entry->recommended.end()};
}

void Recommender::take(const Scene& scene) {
  std::erase_if(left_, [&](const Recommendation& r) { return r.takes && !r.takes(scene); });
  if (left_.empty())
    throw std::logic_error("no recommendation of " + scene.system() + " takes this scene");
}

Recommendation Recommender::chosen() const { return left_.front(); }

}  // namespace stiefel
