#include "engine/catalogue/methods/step_weight.h"

#include <string>

#include "engine/catalogue/methods/weight_table.h"
#include "engine/catalogue/system_entry.h"

namespace stiefel {
namespace {

/// Finds the entry of a scene under the system's name in the table.
const Weight* find(std::string_view system, const Scene& scene) {
  // A closed form, which has no order, is the same in both arithmetics.
  const bool plain = scene.order() > 0 && scene.arithmetic() == Arithmetic::plain;
  return find_weight(system, scene.method(), scene.order(), plain ? "plain" : "compensated",
                     scene.in_float() ? "float" : "double");
}
const Weight* find(const Scene& scene) { return find(scene.system(), scene); }

}  // namespace

FrameSize frame_size(const Scene& scene) {
  const SystemInfo& system = system_entry(scene.system())->info;
  const Eigen::MatrixXd& frame = scene.block(std::string(system.blocks.front().name));
  const double N = scene.dimension();
  return {frame.size() > 0 ? static_cast<double>(frame.rows()) : N, N};
}

bool is_weighed(const Scene& scene) { return find(scene) != nullptr; }

std::optional<std::string> estimate_warning(const Scene& scene) {
  if (scene.method().empty() || is_weighed(scene)) return std::nullopt;
  return "the work of a step of " + scene.method() + " on " + scene.system() +
         " is estimated: the table of counted steps has no entry for it";
}

double step_weight(const Scene& scene) {
  const SystemEntry& system = *system_entry(scene.system());
  const FrameSize size = system.size ? system.size(scene) : frame_size(scene);
  const Weight* found = find(scene);
  return found ? instructions_at(*found, size.n, size.N) : estimated_weight(scene, size);
}

bool price_depends_on_rate(const Scene& scene) {
  const Weight* found = find(scene);
  return found != nullptr && found->rates.size() > 0;
}

double step_price(const Scene& scene, double h_omega) {
  const double weight = step_weight(scene);
  if (!price_depends_on_rate(scene)) return weight;
  return weight * rate_factor(*find(scene), scene.dimension(), h_omega);
}

int pack_lanes(const Scene& one) { return one.in_float() ? 8 : 4; }

std::optional<double> pack_price(const Scene& one, double h_omega) {
  const std::string name = "packed_" + one.system() + (one.has_frame() ? "" : "_momentum");
  const Weight* found = find(name, one);
  if (found == nullptr) return std::nullopt;
  const double N = one.dimension();
  return instructions_at(*found, N, N) * rate_factor(*found, N, h_omega);
}

}  // namespace stiefel
