#pragma once

#include <cstddef>
#include <vector>

#include "server/sessions/server_session.h"
#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the dimension by which the work on a scene is priced and limited: N, or p + q for
/// complex p × q blocks (`inertia_u`, `inertia_v`).
inline int whole_dimension(const Scene& scene) {
  const SceneDescription& given = scene.description();
  return scene.dimension() + static_cast<int>(given.inertia_u.size() + given.inertia_v.size());
}

// A field is named by its index, for `Simulation::write`.

/// Whether a field is sent as binary32: a real field of a scene in single precision. All others are
/// sent as binary64.
bool is_float(const Session& session, std::size_t index);

/// Returns the bytes of a field at one step.
std::size_t field_bytes(const Session& session, std::size_t index);
/// Returns the bytes of the fields with these indices at one step.
std::size_t sample_bytes(const Session& session, const std::vector<std::size_t>& fields);

/// Writes the field with this index at the simulation's step to `out`, which must be aligned for
/// its numbers: `field_bytes` bytes, little-endian and row by row.
void write_field(const Session& session, const Simulation& simulation, std::size_t index,
                 char* out);

}  // namespace stiefel::server
