#pragma once

#include <string>

#include "tests/server/scene_cases.h"

namespace stiefel::test {

/// A geodesic on an ellipsoid whose third semi-axis is a thousandth of the first. It turns so
/// sharply at the edge that `adaptive` tries about twenty times as many substeps as predicted.
inline SceneDescription flat_ellipsoid() {
  SceneDescription scene;
  scene.system = "ellipsoid";
  scene.inertia = {1, 0.8, 1e-6};
  RowMatrix q(1, 3), qdot(1, 3);
  q << 0, 0, 1;
  qdot << 1, 0.1, 0;
  scene.initial["q"] = q;
  scene.initial["qdot"] = qdot;
  scene.step = 0.1;
  scene.method.emplace().name = "adaptive";
  scene.method->tolerance = 1e-12;
  return scene;
}

}  // namespace stiefel::test
