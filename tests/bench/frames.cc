// Measures the variational step on V(4, N): its time relative to copying Q and S, the growth of the
// time with N, and the peak memory of a process that does nothing else. Arguments: repeats, the
// largest N; or "memory", N.
#include <unistd.h>

#include <cmath>
#include <stdexcept>

#include "stiefel/simulation.h"
#include "tests/bench/measure.h"
#include "tests/bench/process.h"
#include "tests/support/scenes/random_frame.h"

namespace {

using namespace stiefel;

constexpr int n = 4;

Scene scene_of(int N, const char* arithmetic) {
  const testing::RandomFrame<double> frame(n, N, 1);
  SceneDescription d;
  d.system = "stiefel";
  d.method = {"variational", 2, 1, arithmetic};
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  d.initial["Q"] = frame.Q;
  d.initial["S"] = frame.S;
  d.step = 0.05 / (frame.S * frame.lambda.cwiseInverse().asDiagonal()).norm();
  return Scene::resolve(std::move(d)).value();
}

double step_seconds(Simulation& simulation, int steps) {
  return bench::processor_seconds([&] {
           if (!simulation.advance(steps).reached()) throw std::runtime_error("a step failed");
         }) /
         steps;
}

double copy_seconds(const Eigen::MatrixXd& from, Eigen::MatrixXd& to, int times) {
  return bench::processor_seconds([&] {
           for (int i = 0; i < times; ++i) {
             to = from;
             asm volatile("" : : "r"(to.data()) : "memory");
           }
         }) /
         times;
}

void times(int repeats, int largest) {
  constexpr int steps = 3;
  for (const char* arithmetic : {"compensated", "plain"}) {
    std::vector<double> exponents(static_cast<std::size_t>(repeats));
    std::vector<double> first;
    for (const int N : {100'000, 1'000'000, 4'000'000}) {
      if (N > largest) break;
      const auto simulation = make_simulation(scene_of(N, arithmetic));
      step_seconds(*simulation, steps);
      const Eigen::MatrixXd state = Eigen::MatrixXd::Random(2 * n, N);
      Eigen::MatrixXd copy = state;
      bench::Comparison against_copying{
          .name = "V(4, N), " + std::string(arithmetic) + ", N = " + std::to_string(N),
          .unit = "ms",
          .rival = "copying Q and S",
          .bound = N == 1'000'000 ? std::optional(4.0) : std::nullopt};
      for (std::size_t i = 0; i < exponents.size(); ++i) {
        const double step = step_seconds(*simulation, steps);
        against_copying.add(1e3 * step, 1e3 * copy_seconds(state, copy, steps));
        if (N == 100'000) first.push_back(step);
        exponents[i] = std::log(step / first[i]) / std::log(N / 1e5);
      }
      report(against_copying);
    }
    if (largest >= 4'000'000)
      report(bench::Figure{"V(4, N), " + std::string(arithmetic) + ", growth of the time",
                           "power of N, 10⁵ … 4·10⁶", 1.1, exponents});
  }
}

void memory(int N) {
  const auto simulation = make_simulation(scene_of(N, "compensated"));
  if (!simulation->advance(2).reached()) throw std::runtime_error("a step failed");
  report(bench::Figure{"V(4, N), N = " + std::to_string(N) + ", peak memory",
                       "MB",
                       1000,
                       {bench::process_status(getpid(), "VmHWM") / 1e3}});
}

}  // namespace

int main(int, char** argv) {
  if (std::string(argv[1]) == "memory")
    memory(std::stoi(argv[2]));
  else
    times(std::stoi(argv[1]), std::stoi(argv[2]));
}
