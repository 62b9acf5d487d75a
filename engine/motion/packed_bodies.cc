#include "engine/motion/packed_bodies.h"

#include "engine/motion/step_weight.h"
#include "engine/motion/system_entry.h"

namespace stiefel {

PackedBodies::~PackedBodies() = default;

int body_lanes(const Scene& scene) { return system_entry(scene.system())->packs->lanes(scene); }

bool can_be_packed(const Scene& scene) {
  const Packs* packs = system_entry(scene.system())->packs;
  return packs && packs->takes(scene);
}

double step_cost(const Scene& first, const Simulation& one, std::size_t members,
                 std::size_t packed) {
  return static_cast<double>(members - packed) * one.step_cost() +
         first.substeps() * nanoseconds(ensemble_step_price(first, packed, step_weight(first)));
}

double ensemble_step_price(const Scene& one, std::size_t members, double alone) {
  const auto pack = can_be_packed(one) ? pack_price(one) : std::nullopt;
  if (!pack) return alone * static_cast<double>(members);
  const auto lanes = static_cast<std::size_t>(one.in_float() ? 8 : 4);
  const std::size_t left = members % lanes;
  const std::size_t packs = members / lanes + (left > 1);
  return *pack * static_cast<double>(packs) + (left == 1 ? alone : 0);
}

}  // namespace stiefel
