#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <vector>

#include "server/sessions/server_session.h"
#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the dimension by which the work on a scene is limited: N, or p + q for complex p × q
/// blocks (`inertia_u`, `inertia_v`).
inline int whole_dimension(const Scene& scene) {
  const SceneDescription& given = scene.description();
  return scene.dimension() + static_cast<int>(given.inertia_u.size() + given.inertia_v.size());
}

// A field is named by its index, for `Simulation::write`.

/// Whether a field is sent as binary32: a real field of a scene in single precision. All others are
/// sent as binary64.
inline bool is_float(const Session& session, std::size_t index) {
  const bool complex = index < session.fields().size() && session.fields()[index].complex;
  return session.scene().in_float() && !complex;
}

/// Returns the bytes of a field at one step.
inline std::size_t field_bytes(const Session& session, std::size_t index) {
  return field_size(session.fields(), index) *
         (is_float(session, index) ? sizeof(float) : sizeof(double));
}

/// Returns the bytes of the fields with these indices at one step.
inline std::size_t sample_bytes(const Session& session, const std::vector<std::size_t>& fields) {
  std::size_t bytes = 0;
  for (const std::size_t index : fields) bytes += field_bytes(session, index);
  return bytes;
}

/// Writes the field with this index at the simulation's step to `out`, which must be aligned for
/// its numbers: `field_bytes` bytes, little-endian and row by row.
inline void write_field(const Session& session, const Simulation& simulation, std::size_t index,
                        char* out) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t size = field_size(session.fields(), index);
  if (!is_float(session, index))
    return simulation.write(index, {reinterpret_cast<double*>(out), size});
  std::vector<double> numbers(size);
  simulation.write(index, numbers);
  std::ranges::transform(numbers, reinterpret_cast<float*>(out),
                         [](double number) { return static_cast<float>(number); });
}

}  // namespace stiefel::server
