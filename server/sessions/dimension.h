#pragma once

#include "stiefel/scene.h"

namespace stiefel::server {

/// Returns the dimension by which the work on a scene is priced and limited: N, or p + q for
/// complex p × q blocks (`inertia_u`, `inertia_v`).
inline int whole_dimension(const Scene& scene) {
  const SceneDescription& given = scene.description();
  return scene.dimension() + static_cast<int>(given.inertia_u.size() + given.inertia_v.size());
}

}  // namespace stiefel::server
