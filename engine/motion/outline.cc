#include <numeric>

#include "engine/motion/flat_bodies.h"
#include "engine/motion/given_members.h"
#include "engine/motion/packed_bodies.h"
#include "stiefel/price.h"
#include "stiefel/stop.h"

namespace stiefel {

std::vector<std::size_t> default_fields(const Scene& scene, const std::vector<Field>& offered,
                                        std::size_t block_count) {
  if (!scene.description().body) {
    std::vector<std::size_t> blocks(block_count);
    std::iota(blocks.begin(), blocks.end(), 0);
    return blocks;
  }
  return {*find_field(offered, "quaternion"), *find_field(offered, "angular_velocity")};
}

Outline outline_of(const Simulation& simulation) {
  return {simulation.fields(), simulation.block_count(), simulation.saved_size(),
          simulation.step_cost(), simulation.direct()};
}

Outline outline_of(const Scene& ensemble,
                   const std::function<void(const Scene&, const Simulation&)>& look) {
  const Members members = ensemble.members();
  const Scene first = members.front();
  const auto one = make_simulation(first);
  const bool alike = GivenMembers(ensemble.description(), first).any() && can_be_packed(first);
  const std::size_t seen = alike ? 1 : members.size();
  std::size_t packed = members.size() - seen;
  for (std::size_t b = 0; b < seen; ++b) {
    stop_point();
    const Scene member = members[b];
    look(member, *make_simulation(member));
    packed += can_be_packed(member);
  }
  Outline out = outline_of(*one);
  for (Field& field : out.fields) field.members = static_cast<int>(members.size());
  out.saved_size *= members.size();
  out.numbers = has_flat_bodies(ensemble);
  out.step_cost = step_cost(first, *one, members.size(), packed);
  return out;
}

}  // namespace stiefel
