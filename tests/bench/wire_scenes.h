#pragma once

#include <string>

#include "server/convert/convert.h"
#include "stiefel/v1/scene.pb.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel::bench {

/// h‖Ω‖ of every scene that is measured.
inline constexpr double h_omega = 0.05;

/// Returns the message of a seeded body's scene with the method `variational`.
inline stiefel::v1::Scene wire_scene(int N, unsigned seed = 1) {
  stiefel::v1::Scene scene;
  server::to_proto(testing::description(testing::RandomBody(N, seed), h_omega, "variational"),
                   &scene);
  return scene;
}

}  // namespace stiefel::bench
