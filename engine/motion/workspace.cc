#include <algorithm>
#include <string_view>

#include "engine/motion/system_entry.h"
#include "stiefel/price.h"

namespace stiefel {
namespace {

/// Number of matrices that a method keeps, counted with mallinfo2 in scenes with 4 <= N <= 128.
struct Workspace {
  std::string_view method;  ///< empty for a discrete system
  int order;                ///< 0 for every order
  double square;            ///< of N x N matrices where n = N
  double wide, rows;        ///< where n < N: of n x N and of n x n matrices
  double body;              ///< of 3 x 3 matrices in three dimensions
  double kilobytes;         ///< independent of the size
};

constexpr Workspace workspaces[] = {
#include "engine/motion/workspaces.inc"
};
/// Assumed for a method that is not in the table.
constexpr Workspace unknown = {"", 0, 200, 100, 100, 100, 40};

/// Bytes of a simulation and its lane in a pack without the matrices.
constexpr double object = 2200;
/// Bytes of a resolved scene without large arrays: strings, maps and vectors.
constexpr std::size_t object_of_scene = 2200;

const Workspace& workspace_of(const Scene& scene) {
  const auto* found = std::ranges::find_if(workspaces, [&](const Workspace& one) {
    return one.method == scene.method() && (one.order == 0 || one.order == scene.order());
  });
  return found == std::end(workspaces) ? unknown : *found;
}

/// Number of N x N matrices that a view keeps beside its body: the scene's blocks, and the start.
constexpr double of_view = 8;

double numbers(const Workspace& kept, double n, double N) {
  if (n < N) return kept.wide * n * N + kept.rows * n * n + kept.kilobytes * 128;
  if (N <= 3) return kept.body * N * N;
  return kept.square * N * N + kept.kilobytes * 128;
}

double numbers(const Scene& scene) {
  const Workspace& kept = workspace_of(scene);
  const SystemEntry& system = *system_entry(scene.system());
  const auto [n, N] = frame_size(scene);
  const auto& initial = scene.description().initial;
  const bool complex = !initial.empty() && initial.begin()->second.imaginary.size() > 0;
  // A complex n x N state moves under U(n) x U(N).
  if (complex) return 2 * kept.square * (n * n + N * N + n * N) + kept.kilobytes * 128;
  return numbers(kept, n, N) + (system.view ? of_view * N * N : 0);
}

}  // namespace

std::size_t simulation_bytes(const Scene& scene) {
  const auto members = scene.members();
  const double kept = members.empty() ? numbers(scene) : numbers(members.front());
  return static_cast<std::size_t>(object + sizeof(double) * kept) *
         std::max<std::size_t>(members.size(), 1);
}

std::size_t array_bytes(const SceneDescription& of) {
  std::size_t numbers = of.inertia.size() + of.inertia_u.size() + of.inertia_v.size();
  for (const auto& [name, block] : of.initial)
    numbers += static_cast<std::size_t>(block.values.size() + block.imaginary.size());
  if (of.body)
    numbers += of.body->inertia_tensor.size() + of.body->moments.size() + of.body->attitude.size() +
               of.body->angular_velocity.size();
  return numbers * sizeof(double);
}

std::size_t largest_simulation_bytes(double n, double N) {
  double most = 0;
  for (const Workspace& one : workspaces) most = std::max(most, numbers(one, n, N));
  return static_cast<std::size_t>(sizeof(double) * most + object);
}

std::size_t scene_bytes(const SceneDescription& description) {
  // Counts the arrays as given and as the blocks from which a simulation starts. These have M in
  // addition to P, or P to M, and are half as large again. The members of an ensemble are made when
  // they are asked for, so only the blocks of one member are counted.
  const std::size_t arrays = array_bytes(description);
  if (!description.members) return arrays * 5 / 2 + object_of_scene;
  const auto members = static_cast<std::size_t>(std::max(*description.members, 1));
  return arrays + arrays / members * 5 / 2 + 2 * object_of_scene;
}

}  // namespace stiefel
