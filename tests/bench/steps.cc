// Compares the processor time of a step of each method to that of rk4, with another seeded body in
// each repeat. h‖Ω‖ = 0.05; 0.1 for order 10. Arguments: repeats, seconds per measurement, largest
// N.
#include <stdexcept>

#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

// Steps after which a warm-started solver has a full history.
constexpr int warm_up = 16;

double step_microseconds(int N, unsigned seed, const MethodDescription& method, double h_omega,
                         double duration) {
  auto scene = testing::description(testing::RandomBody(N, seed), h_omega, "");
  scene.system = "rigid_body";
  scene.method = method;
  const auto simulation = make_simulation(Scene::resolve(scene).value());
  const auto advance = [&](std::int64_t steps) {
    return bench::processor_seconds([&] {
      if (!simulation->advance(steps).reached()) throw std::runtime_error("a step failed");
    });
  };
  advance(warm_up);
  std::int64_t steps = 4;
  double time = advance(steps);
  while (time < duration / 4) time = advance(steps *= 2);
  std::vector<double> times;
  for (int i = 0; i < 3; ++i) times.push_back(1e6 * advance(steps) / static_cast<double>(steps));
  return bench::median(times);
}

/// Compares a step of order 10 to one of order 2.
bench::Comparison order_10(const std::string& arithmetic, int repeats, double duration) {
  bench::Comparison comparison{
      .name = "preprocessed_variational, order 10, " + arithmetic + ", N = 3",
      .unit = "µs",
      .rival = "rk4, the same"};
  if (arithmetic == "plain") comparison.bound = 1.6;
  for (int i = 0; i < repeats; ++i) {
    const auto time = [&](const char* method, std::optional<int> order) {
      const auto seed = static_cast<unsigned>(i + 1);
      return step_microseconds(3, seed, {method, order, {}, arithmetic}, 0.1, duration);
    };
    const double rk4 = time("rk4", {});
    comparison.add(time("preprocessed_variational", 10), rk4);
  }
  return comparison;
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[1]), largest = std::stoi(argv[3]);
  const double duration = std::stod(argv[2]);
  for (const int N : {3, 8, 64, 256}) {
    if (N > largest) break;
    for (const char* arithmetic : {"compensated", "plain"}) {
      const auto comparison = [&](const char* method) {
        return bench::Comparison{
            .name = std::string(method) + ", " + arithmetic + ", N = " + std::to_string(N),
            .unit = "µs",
            .rival = "rk4, the same"};
      };
      auto variational = comparison("variational"), munthe_kaas4 = comparison("munthe_kaas4");
      for (int i = 0; i < repeats; ++i) {
        const auto time = [&](const char* method) {
          const auto seed = static_cast<unsigned>(i + 1);
          return step_microseconds(N, seed, {method, {}, {}, arithmetic}, 0.05, duration);
        };
        const double rk4 = time("rk4");
        variational.add(time("variational"), rk4);
        munthe_kaas4.add(time("munthe_kaas4"), rk4);
      }
      report(variational);
      report(munthe_kaas4);
      if (N == 3) report(order_10(arithmetic, repeats, duration));
    }
  }
}
