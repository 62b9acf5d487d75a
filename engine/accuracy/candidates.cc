#include "engine/accuracy/candidates.h"

#include <algorithm>
#include <cmath>

#include "engine/motion/step_weight.h"
#include "engine/numbers/to_text.h"
#include "stiefel/catalogue.h"
#include "stiefel/invariant_names.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

bool keeps_energy(const MethodOnSystem& on) {
  return std::ranges::none_of(on.preserves, [](const Preservation& p) {
    return p.invariant == family::energy && p.conservation == Conservation::drifts;
  });
}

}  // namespace

std::optional<MethodDescription> Candidate::refined(int r) const {
  constexpr int last_doubling = 16, last_decade = 12;
  if (r > (is_closed_form() ? 0 : own_steps ? last_decade : last_doubling)) return std::nullopt;
  MethodDescription made = method;
  if (own_steps)
    made.tolerance = std::pow(10, -3 - r);
  else
    made.substeps = 1 << r;
  return made;
}

std::expected<std::vector<Scene>, Violations> motions_of(SceneDescription description) {
  const SystemInfo* system = catalogue().system(description.system);
  if (system != nullptr && system->discrete)
    return std::unexpected(Violations{Violation{
        "system", '"' + description.system + '"',
        "is a discrete system and takes no method, so there is no trade-off to measure"}});
  description.method.reset();
  description.tolerance.reset();
  auto start = resolve_recommending(std::move(description), Scene::frame_tolerance);
  if (!start) return std::unexpected(std::move(start.error()));
  if (start->members().empty()) return std::vector{*std::move(start)};
  return start->members().range(0, start->members().size());
}

std::expected<std::vector<Candidate>, Violations> candidates(const Scene& start) {
  Violations refused;
  std::vector<Candidate> all;
  const auto consider = [&](const MethodOnSystem& on, std::optional<int> order,
                            const char* arithmetic, const char* scalar) {
    stop_point();
    const MethodInfo& info = *catalogue().method(on.method);
    const MethodDescription method{std::string(on.method), order, 1, arithmetic, {}, scalar};
    auto scene = start.with(method);
    if (scene)
      all.push_back({method, order.value_or(0), info.default_tolerance > 0,
                     keeps_energy(on) && !scene->in_float(), step_weight(*scene)});
    else if (refused.empty())
      refused = std::move(scene.error());
  };
  for (const auto& on : catalogue().system(start.system())->methods) {
    const auto& orders = catalogue().method(on.method)->orders;
    for (const int order : orders)
      for (const char* arithmetic : {"plain", "compensated"}) {
        consider(on, order, arithmetic, "double");
        if (on.in_float && start.dimension() == 3) consider(on, order, arithmetic, "float");
      }
    if (orders.empty()) consider(on, std::nullopt, "compensated", "double");
  }
  if (all.empty()) return std::unexpected(std::move(refused));
  return all;
}

std::string to_text(const MethodDescription& method) {
  std::string text = method.name;
  const MethodInfo* info = catalogue().method(method.name);
  if (info->orders.size() > 1)
    text += " of order " + std::to_string(method.order.value_or(info->default_order));
  if (method.tolerance) text += " with tolerance " + to_text(*method.tolerance);
  const int m = method.substeps.value_or(1);
  if (m > 1) text += ", " + std::to_string(m) + " substeps";
  text += ", " + method.arithmetic;
  return method.scalar == "float" ? text + ", in float" : text;
}

}  // namespace stiefel
