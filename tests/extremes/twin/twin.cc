#include "tests/extremes/twin/twin.h"

#include <algorithm>

#include "tests/extremes/bodies.h"
#include "tests/extremes/twin/twin_of.h"

namespace stiefel::extremes {

std::unique_ptr<Twin> make_twin(const Scene& scene, double perturbation, unsigned seed) {
  const Perturbation moved(perturbation, seed);
  if (scene.system() == "stiefel") return twin_of_frames(scene, moved);
  const bool body = scene.system() == "rigid_body" || scene.system() == "moser_veselov";
  if (!body || !scene.has_frame()) return nullptr;
  if (scene.dimension() == 3) return twin_in_three(scene, moved);
  return scene.dimension() < Twin::wide_from ? twin_in_many(scene, moved)
                                             : twin_in_many_wide(scene, moved);
}

namespace {

/// Returns whether a method rotates M as a whole, so that it represents elements of M to u‖M‖;
/// other methods represent each element to a relative u.
bool rounds_M_as_a_whole(const std::string& method) {
  for (const char* name : {"munthe_kaas4", "implicit_midpoint"})
    if (method == name) return true;
  return false;
}

/// Returns the scene with each element of M changed by up to `part` times the largest element.
Scene with_M_moved(const Scene& scene, double part, unsigned seed) {
  SceneDescription moved = scene.description();
  RowMatrix& M = moved.initial.at("M").values;
  const RowMatrix A = random_matrix(M.rows(), M.cols(), seed);
  M += part / 2 * M.cwiseAbs().maxCoeff() * (A - A.transpose());
  return Scene::resolve(moved).value();
}

MotionState end_of(const std::unique_ptr<Twin>& twin, std::int64_t steps) {
  twin->advance(steps);
  return twin->state();
}

}  // namespace

double condition(const Scene& scene, std::int64_t steps) {
  // The changes must be well above the rounding of the comparison, which is in extended precision,
  // and of the initial M of `with_M_moved`, which is in double.
  constexpr double part = 0x1p-46, part_of_M = 0x1p-34;
  const MotionState end = end_of(make_twin(scene), steps);
  double largest = 1;
  for (const unsigned seed : {1u, 2u}) {
    const auto moved = end_of(make_twin(scene, part, seed), steps);
    largest = std::max(largest, error_of(moved, end).largest() / part);
    if (!rounds_M_as_a_whole(scene.method())) continue;
    const auto as_a_whole = end_of(make_twin(with_M_moved(scene, part_of_M, seed)), steps);
    largest = std::max(largest, error_of(as_a_whole, end).largest() / part_of_M);
  }
  return largest;
}

}  // namespace stiefel::extremes
