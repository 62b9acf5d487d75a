// Makes steps of which callgrind can tell what the threads would share: a crew that says that it
// has two threads does the pieces of the work on this thread, each inside `divided_piece`, and all
// steps are inside `counted_steps`. Arguments: N and h|Omega| of a body, or "frames" and the N of
// V(4, N); steps.
#include "stiefel/crew.h"
#include "stiefel/simulation.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

struct Work {
  Crew::Item item;
  void* context;
};

}  // namespace

extern "C" [[gnu::noinline]] void divided_piece(void* work, std::size_t index) {
  const Work& whole = *static_cast<Work*>(work);
  whole.item(whole.context, index);
}

extern "C" [[gnu::noinline]] bool counted_steps(stiefel::Simulation& simulation, int steps) {
  return simulation.advance(steps).reached();
}

namespace {

class OneByOne final : public Crew {
 public:
  std::size_t threads_at_hand() override { return 2; }
  void run(std::size_t count, double, Item item, void* context) override {
    Work work{item, context};
    team_.run(count, 1, divided_piece, &work);
  }

 private:
  Team team_;
};

Scene frames(int N) {
  const testing::RandomFrame<double> frame(4, N, 1);
  SceneDescription d;
  d.system = "stiefel";
  d.method = {"variational", 2, 1, "plain"};
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial["Q"] = frame.Q;
  d.initial["S"] = frame.S;
  d.step = 0.05;
  return Scene::resolve(std::move(d)).value();
}

Scene body(int N, double h_omega) {
  return Scene::resolve(
             testing::description(testing::RandomBody(N, 1), h_omega, "variational", "plain"))
      .value();
}

}  // namespace

int main(int, char** argv) {
  constexpr int warm_up = 16;  // the steps after which a solver has a full history
  const std::string what = argv[1];
  const auto simulation = make_simulation(
      what == "frames" ? frames(std::stoi(argv[2])) : body(std::stoi(what), std::stod(argv[2])));
  limit_threads(1);
  if (!simulation->advance(warm_up).reached()) return 1;
  OneByOne crew;
  const CrewOfThisThread mine(crew);
  return counted_steps(*simulation, std::stoi(argv[3])) ? 0 : 1;
}
