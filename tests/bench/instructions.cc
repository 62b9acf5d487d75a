// So many steps and nothing else, for valgrind to count. Arguments: method, N, steps.
#include "engine/simulation/simulation.h"
#include "tests/support/random_scene.h"

int main(int, char** argv) {
  const auto simulation = stiefel::make_simulation(
      stiefel::testing::random_scene(std::stoi(argv[2]), 1, 0.05, argv[1]));
  return simulation->advance(std::stoll(argv[3])).reached() ? 0 : 1;
}
