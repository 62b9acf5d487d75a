#include "tests/extremes/twin.h"

#include <algorithm>

#include "tests/extremes/twin_of.h"

namespace stiefel::extremes {

namespace {

/// Methods that turn M as a whole know its elements to u‖M‖; the others to u each.
bool holds_M_as_a_whole(const std::string& method) {
  for (const char* name : {"munthe_kaas4", "crouch_grossman3", "implicit_midpoint", "gauss4"})
    if (method == name) return true;
  return false;
}

}  // namespace

std::unique_ptr<Twin> make_twin(const Scene& scene, double perturbation, unsigned seed) {
  const Perturbation moved(perturbation, seed, holds_M_as_a_whole(scene.method()));
  if (scene.system() == "stiefel") return twin_of_frames(scene, moved);
  const bool body = scene.system() == "rigid_body" || scene.system() == "moser_veselov";
  if (!body || !scene.has_frame()) return nullptr;
  if (scene.dimension() == 3) return twin_in_three(scene, moved);
  return scene.dimension() < Twin::wide_from ? twin_in_many(scene, moved)
                                             : twin_in_many_wide(scene, moved);
}

double condition(const Scene& scene, std::int64_t steps) {
  // States are compared in extended precision.
  constexpr double part = 0x1p-46;
  const auto at_end = [&](double perturbation, unsigned seed) {
    const auto twin = make_twin(scene, perturbation, seed);
    twin->advance(steps);
    return twin->state();
  };
  const MotionState end = at_end(0, 0);
  double largest = 1;
  for (const unsigned seed : {1u, 2u})
    largest = std::max(largest, error_of(at_end(part, seed), end).largest() / part);
  return largest;
}

}  // namespace stiefel::extremes
