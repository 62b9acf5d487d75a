#include <algorithm>
#include <numeric>

#include "engine/motion/groups.h"
#include "stiefel/price.h"

namespace stiefel {

std::vector<std::size_t> default_fields(const Scene& scene, const std::vector<Field>& offered,
                                        std::size_t block_count) {
  if (!scene.description().body) {
    std::vector<std::size_t> blocks(block_count);
    std::iota(blocks.begin(), blocks.end(), 0);
    return blocks;
  }
  const auto index = [&](const char* name) {
    return static_cast<std::size_t>(std::ranges::find(offered, name, &Field::name) -
                                    offered.begin());
  };
  return {index("quaternion"), index("angular_velocity")};
}

Outline outline_of(const Simulation& simulation) {
  return {simulation.fields(), simulation.block_count(), simulation.saved_size(),
          simulation.step_cost(), simulation.direct()};
}

Outline outline_of(const Members& members,
                   const std::function<void(const Scene&, const Simulation&)>& look) {
  Outline out;
  for_each_group(members, 0, members.size(), [&](std::span<const Scene> group, std::size_t) {
    std::unique_ptr<Simulation> one;
    for (const Scene& scene : group) {
      one = make_simulation(scene);
      look(scene, *one);
    }
    if (out.fields.empty()) {
      const double before = out.step_cost;
      out = outline_of(*one);
      out.step_cost = before;
    }
    out.step_cost += group_cost(group, *one);
  });
  for (Field& field : out.fields) field.members = static_cast<int>(members.size());
  out.saved_size *= members.size();
  return out;
}

}  // namespace stiefel
