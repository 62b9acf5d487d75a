#pragma once

#include <string>
#include <vector>

#include "server/scheduling/principal.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

namespace stiefel::test {

/// The principal of a server without tokens.
inline const server::Principal everybody;

/// A motion that is neither constant nor linear; h ||Omega|| is about 0.03.
struct Case {
  std::string system = "rigid_body";
  std::string method = "variational";
  std::string arithmetic = "compensated";
  int dimension = 3;
};

inline SceneDescription description(const Case& which = {}) {
  const int N = which.dimension;
  SceneDescription scene;
  scene.system = which.system;
  if (!which.method.empty()) {
    scene.method = MethodDescription{which.method, std::nullopt, std::nullopt, which.arithmetic};
  }
  scene.step = 0.01;
  RowMatrix M(N, N);
  for (int i = 0; i < N; ++i) {
    scene.inertia.push_back(1 + 0.5 * i);
    for (int j = 0; j < N; ++j) M(i, j) = (i - j) * (1 + 0.3 * (i + j)) * ((i + j) % 2 ? 1 : -0.7);
  }
  scene.initial["Q"] = RowMatrix(RowMatrix::Identity(N, N));
  scene.initial["M"] = M;
  return scene;
}

inline Scene scene(const Case& which = {}) { return Scene::resolve(description(which)).value(); }

/// The complete state, as bytes compare it.
inline std::vector<double> saved(const Simulation& simulation) {
  std::vector<double> out(simulation.saved_size());
  simulation.save(out);
  return out;
}

/// Without any of the server's code.
inline std::vector<double> expected_state(const Scene& scene, std::int64_t step) {
  const auto simulation = make_simulation(scene);
  simulation->advance(step);
  return saved(*simulation);
}

}  // namespace stiefel::test
