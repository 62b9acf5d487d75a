// Compares the processor time of a summary that reads every step to that of the same steps alone:
// one body, the drift of its energy and its last attitude. Arguments: repeats, seconds per
// measurement.
#include <stdexcept>

#include "stiefel/simulation.h"
#include "stiefel/summary.h"
#include "tests/bench/measure.h"
#include "tests/support/scenes/random_scene.h"

namespace {

using namespace stiefel;

/// Steps per call of `advance`: as many as a slice of the server has.
constexpr std::int64_t slice = 4096;

double unread(const Scene& scene, std::int64_t steps) {
  const auto simulation = make_simulation(scene);
  return bench::processor_seconds([&] {
    for (std::int64_t done = 0; done < steps; done += slice)
      if (!simulation->advance(std::min(slice, steps - done)).reached())
        throw std::runtime_error("the body stopped");
  });
}

double read(const Scene& scene, std::int64_t steps) {
  SummaryDescription what{.to = steps};
  what.quantities = {{"energy", {Statistic::drift}}, {"quaternion", {Statistic::last}}};
  const auto summary = Summary::prepare(scene, what).value();
  const double time = bench::processor_seconds([&] {
    while (!summary->done()) summary->advance(slice, steps);
  });
  if (!summary->status().reached()) throw std::runtime_error("the body stopped");
  return time;
}

}  // namespace

int main(int argc, char** argv) {
  const int repeats = argc > 1 ? std::atoi(argv[1]) : 5;
  const double duration = argc > 2 ? std::atof(argv[2]) : 0.5;
  for (const int order : {4, 10}) {
    auto description =
        testing::description(testing::RandomBody(3, 1), 0.1, "preprocessed_variational");
    description.method->order = order;
    const Scene scene = Scene::resolve(description).value();
    std::int64_t steps = slice;
    while (unread(scene, steps) < duration / 2) steps *= 2;
    bench::Comparison comparison{.name = "summary of one body, order " + std::to_string(order) +
                                         ": drift of the energy at every step, last attitude",
                                 .unit = "s",
                                 .rival = "the same steps unread",
                                 .bound = 1.35};
    for (int i = 0; i < repeats; ++i) comparison.add(read(scene, steps), unread(scene, steps));
    bench::report(comparison);
  }
}
