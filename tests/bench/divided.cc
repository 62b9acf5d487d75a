// Makes steps of which one can tell what the threads would share: a crew that says that it has two
// or more threads does the pieces of the work on this one, each inside `divided_piece`, and all
// steps are inside `counted_steps`, for callgrind. Prints how much faster as many threads would
// make the fastest step: each takes the next piece as soon as it is free, and nothing disturbs it.
// Arguments: N and h|Omega| of a body, or "frames" and the N of V(4, N); steps; threads ...
#include <algorithm>
#include <limits>

#include "stiefel/crew.h"
#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/support/scenes/random_frame.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

struct Work {
  Crew::Item item;
  void* context;
  std::vector<double> seconds;  ///< of each piece
};

}  // namespace

extern "C" [[gnu::noinline]] void divided_piece(void* work, std::size_t index) {
  Work& whole = *static_cast<Work*>(work);
  whole.seconds.push_back(stiefel::bench::seconds([&] { whole.item(whole.context, index); }));
}

extern "C" [[gnu::noinline]] bool counted_steps(stiefel::Simulation& simulation, int steps) {
  return simulation.advance(steps).reached();
}

namespace {

class OneByOne final : public Crew {
 public:
  explicit OneByOne(std::size_t threads) : threads_(threads) {}
  std::size_t threads_at_hand() override { return threads_; }
  void run(std::size_t count, double, Item item, void* context) override {
    Work work{item, context, {}};
    work.seconds.reserve(count);
    team_.run(count, 1, divided_piece, &work);
    std::vector<double> busy(threads_);  // until when each thread is
    for (const double piece : work.seconds) {
      *std::ranges::min_element(busy) += piece;
      saved_ += piece;
    }
    saved_ -= *std::ranges::max_element(busy);
  }
  /// Returns the seconds that the threads would have saved since the last call.
  double take_saved() { return std::exchange(saved_, 0); }

 private:
  std::size_t threads_;
  double saved_ = 0;
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

int main(int argc, char** argv) {
  constexpr int warm_up = 16;  // the steps after which a solver has a full history
  const std::string what = argv[1], size = argv[2];
  const bool frame = what == "frames";
  const auto simulation =
      make_simulation(frame ? frames(std::stoi(size)) : body(std::stoi(what), std::stod(size)));
  limit_threads(1);
  if (!simulation->advance(warm_up).reached()) return 1;
  for (int k = 4; k < argc; ++k) {
    OneByOne crew(std::stoul(argv[k]));
    const CrewOfThisThread mine(crew);
    double alone = std::numeric_limits<double>::infinity(), shared = alone;
    for (int step = 0; step < std::stoi(argv[3]); ++step) {
      const double seconds = bench::seconds([&] {
        if (!counted_steps(*simulation, 1)) throw std::runtime_error("a step failed");
      });
      alone = std::min(alone, seconds);
      shared = std::min(shared, seconds - crew.take_saved());
    }
    bench::Figure figure{(frame ? "V(4, " + size + ")" : "N = " + what + ", h|Omega| = " + size) +
                             ", plain, pieces dealt to " + argv[k] + " threads",
                         "times as fast"};
    figure.values = {alone / shared};
    report(figure);
  }
}
