#include "engine/growth/tangent_of.h"

#include "engine/motion/system_entry.h"

namespace stiefel {
namespace {

void append(std::string& list, std::string_view name) {
  if (!list.empty()) list += ", ";
  list += name;
}

}  // namespace

const Tangents* tangents_of(std::string_view system) {
  const SystemEntry* entry = system_entry(system);
  return entry ? entry->tangents : nullptr;
}

const MethodTangent* tangent_of(const Scene& scene, std::string_view method) {
  const Tangents* tangents = tangents_of(scene.system());
  if (!tangents) return nullptr;
  for (const MethodTangent& of : tangents->methods)
    if (of.method == method && (of.dimension == 0 || of.dimension == scene.dimension())) return &of;
  return nullptr;
}

Violations without_tangent(const Scene& scene) {
  if (!scene.members().empty())
    return {Violation{"", std::to_string(scene.members().size()) + " members",
                      "the scene must have no `members`"}};
  if (tangent_of(scene, scene.method())) return {};
  std::string have;
  if (const Tangents* tangents = tangents_of(scene.system())) {
    for (const MethodTangent& of : tangents->methods)
      append(have, std::string(of.method) +
                       (of.dimension > 0 ? " (N = " + std::to_string(of.dimension) + ")" : ""));
    return {Violation{"method", scene.method(),
                      "has no tangent for " + scene.system() +
                          " at N = " + std::to_string(scene.dimension()) + "; " + have + " have"}};
  }
  for (const SystemEntry& entry : system_entries())
    if (entry.tangents) append(have, entry.info.name);
  return {
      Violation{"system", scene.system(), "has no tangent by any method; " + have + " have one"}};
}

}  // namespace stiefel
