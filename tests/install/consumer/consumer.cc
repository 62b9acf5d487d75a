// A program outside the project: a free rigid body, a thousand steps, its energy before and after.
#include <cstdlib>
#include <iostream>

#include "stiefel/diagnosis.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"

int main() {
  stiefel::SceneDescription description;
  description.system = "rigid_body";
  description.method = stiefel::MethodDescription{.name = "variational"};
  description.inertia = {2.5, 1.5, 0.5};
  description.initial["Q"] = stiefel::RowMatrix::Identity(3, 3);
  description.initial["M"] = stiefel::RowMatrix{{0, -1, 2}, {1, 0, -0.5}, {-2, 0.5, 0}};
  description.step = 0.01;

  const auto scene = stiefel::Scene::resolve(description);
  if (!scene) return EXIT_FAILURE;
  const auto simulation = stiefel::make_simulation(*scene);
  if (!simulation->advance(1000).reached()) return EXIT_FAILURE;

  const std::string energy[] = {"energy"};
  const auto drift = stiefel::diagnose(*scene, *simulation, energy).invariants.at(0).drift();
  std::cout << "step " << simulation->step() << ", energy drift " << drift << '\n';
  return simulation->step() == 1000 && drift < 1e-12 ? EXIT_SUCCESS : EXIT_FAILURE;
}
