#pragma once

#include <string>

#include "server/convert/convert.h"
#include "stiefel/v1/scene.pb.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::bench {

/// h‖Ω‖ of every scene measured.
inline constexpr double h_omega = 0.05;

/// A seeded body under `variational`, as it goes over the wire.
inline stiefel::v1::Scene wire_scene(int N, unsigned seed = 1) {
  stiefel::v1::Scene scene;
  server::to_proto(testing::description(testing::RandomBody(N, seed), h_omega, "variational"),
                   &scene);
  return scene;
}

}  // namespace stiefel::bench
