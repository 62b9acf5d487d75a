// A program outside the project. It runs a free rigid body for a thousand steps in the engine and
// checks that the energy did not drift. With the client it does the same on a server, whose program
// is the argument, and checks that the momentum at the end has the same bits.
#include <cstdlib>
#include <iostream>

#include "stiefel/diagnosis.h"
#include "stiefel/scene.h"
#include "stiefel/simulation.h"
#ifdef WITH_CLIENT
#include "remote.h"
#endif

int main([[maybe_unused]] int argc, [[maybe_unused]] char** argv) {
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
  if (simulation->step() != 1000 || !(drift < 1e-12)) return EXIT_FAILURE;
#ifdef WITH_CLIENT
  if (argc != 2) return EXIT_FAILURE;
  const Eigen::MatrixXd remote = remote_momentum(argv[1], description, 1000);
  if (remote != simulation->get("M")) return EXIT_FAILURE;
  std::cout << "a server computes the same bits\n";
#endif
  return EXIT_SUCCESS;
}
