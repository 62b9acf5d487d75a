#pragma once

#include <ostream>
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

  std::string name() const {
    return system + "_" + method + "_" + arithmetic + "_" + std::to_string(dimension);
  }
  friend void PrintTo(const Case& which, std::ostream* out) { *out << which.name(); }
};

inline std::vector<Case> cases() {
  std::vector<Case> all;
  for (const int dimension : {3, 5}) {
    all.push_back({"rigid_body", "variational", "compensated", dimension});
    all.push_back({"rigid_body", "variational", "plain", dimension});
    all.push_back({"rigid_body", "rk4", "compensated", dimension});
    all.push_back({"rigid_body", "munthe_kaas4", "compensated", dimension});
    all.push_back({"moser_veselov", "", "", dimension});
  }
  for (const char* method : {"preprocessed_variational", "exact", "splitting"})
    all.push_back({"rigid_body", method, "compensated", 3});
  return all;
}

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
