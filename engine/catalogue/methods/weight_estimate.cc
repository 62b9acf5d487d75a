#include "engine/catalogue/methods/step_weight.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "engine/catalogue/methods/weight_table.h"
#include "engine/catalogue/system_entry.h"

namespace stiefel {
namespace {

struct MethodAndOrder {
  std::string_view method;
  int order;
};

/// Finds the entry in double precision and compensated arithmetic, which every method has.
const Weight* find(std::string_view system, const MethodAndOrder& of) {
  return find_weight(system, of.method, of.order, "compensated", "double");
}

/// Returns the systems in which members of an ensemble do not share a register.
std::set<std::string_view> weighed_systems() {
  std::set<std::string_view> found;
  for (const Weight& weight : weight_table())
    if (!weight.system.starts_with("packed_")) found.insert(weight.system);
  return found;
}

/// Returns the methods of the scene's system, with their default orders, that a system of the table
/// has too.
std::vector<MethodAndOrder> weighed_methods(const Scene& scene) {
  std::vector<MethodAndOrder> found;
  for (const MethodOnSystem& on : catalogue().system(scene.system())->methods) {
    const MethodAndOrder of{on.method, catalogue().method(on.method)->default_order};
    if (std::ranges::any_of(weighed_systems(), [&](auto system) { return find(system, of); }))
      found.push_back(of);
  }
  return found;
}

/// log(work of the method / geometric mean of the work of `methods`) on a system of the table;
/// nullopt where the table lacks one of them.
std::optional<double> log_relative_work(std::string_view system, const MethodAndOrder& method,
                                        const std::vector<MethodAndOrder>& methods,
                                        const FrameSize& size) {
  const auto log_work = [&](const MethodAndOrder& of) -> std::optional<double> {
    const Weight* weight = find(system, of);
    if (weight == nullptr) return std::nullopt;
    return std::log(instructions_at(*weight, size.n, size.N));
  };
  auto relative = log_work(method);
  for (const MethodAndOrder& of : methods) {
    const auto log = log_work(of);
    if (!relative || !log) return std::nullopt;
    *relative -= *log / static_cast<double>(methods.size());
  }
  return relative;
}

double relative_work(const Scene& scene, const FrameSize& size) {
  const auto methods = weighed_methods(scene);
  double sum = 0;
  int count = 0;
  for (const std::string_view system : weighed_systems())
    if (const auto log =
            log_relative_work(system, {scene.method(), scene.order()}, methods, size)) {
      sum += *log;
      ++count;
    }
  return count == 0 ? 1 : std::exp(sum / count);
}

}  // namespace

double estimated_weight(const Scene& scene, const FrameSize& size) {
  constexpr double least = 5000, of_operation = 15;
  return (least + of_operation * operations(size.n, size.N)) * relative_work(scene, size);
}

}  // namespace stiefel
