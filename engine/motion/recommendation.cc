#include "engine/motion/recommendation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "engine/motion/system_entry.h"
#include "stiefel/stop.h"

namespace stiefel {

MethodDescription Recommendation::description() const {
  MethodDescription out{std::string(method), std::nullopt, 1, std::string(arithmetic)};
  if (order > 0) out.order = order;
  if (tolerance > 0) out.tolerance = tolerance;
  return out;
}

int Recommendation::substeps(const Scene& scene) const {
  constexpr double most_substeps = 1e6;
  stop_point();
  if (largest_h_omega == 0) return 1;
  const SystemEntry& entry = *system_entry(scene.system());
  const double Omega = entry.rates && scene.dimension() == 3 ? entry.rates->turning(scene)
                                                             : entry.make(scene)->rate();
  const double needed = std::ceil(std::abs(scene.step()) * Omega / largest_h_omega);
  return static_cast<int>(std::min(std::max(1.0, needed), most_substeps));
}

std::vector<Recommendation> recommended(std::string_view system) {
  const SystemEntry* entry = system_entry(system);
  if (entry == nullptr || entry->info.discrete) return {};
  if (entry->recommended.empty())
    return {{.method = "adaptive", .order = 8, .arithmetic = "compensated", .tolerance = 1e-9}};
  return {entry->recommended.begin(), entry->recommended.end()};
}

void keep_what_takes(const Scene& scene, std::vector<Recommendation>& left) {
  std::erase_if(left, [&](const Recommendation& r) { return r.takes && !r.takes(scene); });
  if (left.empty())
    throw std::logic_error("no recommendation of " + scene.system() + " takes this scene");
}

}  // namespace stiefel
