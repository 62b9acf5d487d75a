// Makes a given number of steps and nothing else, so that callgrind can count them. Arguments:
// method, "frames" for the variational step on V(4, N), or "exact" with a state at every step and
// "exact_alone" with as many states at distances that differ; N; steps.
#include "stiefel/simulation.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

Scene frames(int N) {
  const testing::RandomFrame<double> frame(4, N, 1);
  SceneDescription d;
  d.system = "stiefel";
  d.method = {"variational", 2, 1, ""};
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial["Q"] = frame.Q;
  d.initial["S"] = frame.S;
  d.step = 0.05;
  return Scene::resolve(std::move(d)).value();
}

}  // namespace

int main(int, char** argv) {
  const std::string what = argv[1];
  const int N = std::stoi(argv[2]);
  const std::int64_t steps = std::stoll(argv[3]);
  const bool exact = what.starts_with("exact");
  const auto simulation = make_simulation(
      what == "frames" ? frames(N) : testing::random_scene(N, 1, 0.05, exact ? "exact" : what));
  for (std::int64_t k = 0; exact && k < steps; ++k)
    if (!simulation->advance(what == "exact" ? 1 : k + 3).reached()) return 1;
  if (exact) return 0;
  return simulation->advance(steps).reached() ? 0 : 1;
}
