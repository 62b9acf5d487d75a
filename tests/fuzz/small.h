#pragma once

#include "stiefel/v1/scene.pb.h"

namespace stiefel::fuzz {

/// The limits on work that keep a case to milliseconds: no search for a method, which takes a
/// second, few substeps, and tolerances that are soon met. A scene that is too large is left out.
inline bool make_small(v1::Scene* scene) {
  if (scene->inertia_size() > 8 || scene->ByteSizeLong() > 4096) return false;
  if (!scene->has_method()) {
    scene->clear_tolerance();
    return true;
  }
  auto& method = *scene->mutable_method();
  if (method.substeps() > 4 && method.substeps() <= 1'000'000) method.set_substeps(4);
  if (method.tolerance() < 1e-4) method.clear_tolerance();
  if (method.name() == "adaptive" && !method.has_tolerance()) method.set_tolerance(1e-4);
  return true;
}

}  // namespace stiefel::fuzz
