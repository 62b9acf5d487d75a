#include "stiefel/diagnosis.h"
#include "engine/motion/invariant_list.h"
#include "stiefel/stop.h"

#include <algorithm>
#include <cmath>

namespace stiefel {
namespace {

constexpr int largest_domain_search = 32;
constexpr double domain_search_limit = 8;  // in units of |h|

Conservation conservation(const Scene& scene, std::string_view invariant) {
  for (const auto& method : catalogue().system(scene.system())->methods)
    if (method.method == scene.method())
      for (const auto& p : method.preserves)
        if (p.invariant == invariant) return p.conservation;
  return Conservation::drifts;
}

}  // namespace

bool is_invariant(const Scene& scene, std::string_view name_or_family) {
  const std::string_view family = name_or_family.substr(0, name_or_family.find('['));
  const auto& known = catalogue().system(scene.system())->invariants;
  return std::ranges::any_of(known, [&](const auto& i) { return i.name == family; });
}

namespace {

std::vector<InvariantDrift> drifts(const Scene& scene, const Simulation& now,
                                   std::span<const std::string> only, const std::stop_token& stop) {
  InvariantList before(only, stop), after(only, stop);
  make_simulation(scene)->invariants(before);
  now.invariants(after);
  std::vector<InvariantDrift> out;
  const std::size_t both = std::min(before.entries().size(), after.entries().size());
  for (std::size_t i = 0; i < both; ++i) {
    const auto& start = before.entries()[i];
    out.push_back({start.name, start.value, after.entries()[i].value, start.scale,
                   conservation(scene, start.family)});
  }
  return out;
}

/// Returns for each invariant the drift of the member in which it is largest.
std::vector<InvariantDrift> worst_drifts(const Scene& scene, const Simulation& now,
                                         std::span<const std::string> only,
                                         const std::stop_token& stop) {
  std::vector<InvariantDrift> worst;
  const auto states = now.members();  // brings the states of all members up to date
  for (std::size_t b = 0; b < scene.members().size() && !stop.stop_requested(); ++b) {
    auto one = drifts(scene.members()[b], *states[b], only, stop);
    if (b == 0) worst = one;
    for (std::size_t i = 0; i < std::min(worst.size(), one.size()); ++i)
      if (b == 0 || one[i].drift() > worst[i].drift()) {
        worst[i] = std::move(one[i]);
        worst[i].member = static_cast<std::int64_t>(b);
      }
  }
  return worst;
}

}  // namespace

Diagnosis diagnose(const Scene& scene, const Simulation& now, std::span<const std::string> only,
                   const std::stop_token& stop) {
  Diagnosis diagnosis;
  unless_stopped(stop, [&] {
    diagnosis.invariants = scene.members().empty() ? drifts(scene, now, only, stop)
                                                   : worst_drifts(scene, now, only, stop);
    stop_point();
    diagnosis.orthogonality = now.orthogonality();
    stop_point();
    const double h = std::abs(scene.step()) / scene.substeps();
    diagnosis.h_omega = h * now.rate();
    stop_point();
    if (scene.dimension() <= largest_domain_search)
      diagnosis.largest_step = now.largest_step(domain_search_limit * h);
    diagnosis.motion = body_motion(scene);
    return true;
  });
  return diagnosis;
}

}  // namespace stiefel
