// Compares the processor time of a state of `exact`, N = 3, in the lanes of a register of each
// instruction set of this machine, and side by side in an ensemble, to that of a state alone, which
// is the first of a register of this machine's widest set, at times without a pattern; and a state
// alone to that of Jacobi's formula in extended precision. Arguments: repeats, seconds per
// measurement.
#include <array>
#include <random>

#include "engine/body/exact/top_in_time.h"
#include "engine/numbers/pack.h"
#include "tests/bench/measure.h"
#include "tests/support/scenes/random_top.h"

namespace {

using namespace stiefel;

/// Returns the nanoseconds per state. `compute` computes `count` states.
template <class Compute>
double nanoseconds(double duration, int count, Compute&& compute) {
  std::int64_t calls = 64;
  const auto time = [&] {
    return bench::processor_seconds([&] {
      for (std::int64_t i = 0; i < calls; ++i) compute();
    });
  };
  while (time() < duration / 4) calls *= 2;
  std::vector<double> times;
  for (int i = 0; i < 3; ++i) times.push_back(1e9 * time() / static_cast<double>(calls * count));
  return bench::median(times);
}

TopInTime top_of(unsigned seed) {
  const testing::RandomTop given(10 * seed);  // of the kind "generic"
  return {PrincipalMoments3<Number128>(given.lambda), given.x.cast<long double>()};
}

/// In one register: states of one body, or of one body in each lane.
template <class Bodies>
double in_lanes(double duration, const Bodies& bodies) {
  ThetaTop::Times times{.unit = 0.1, .high = {}, .low = {}};
  ThetaTop::Lanes states;
  return nanoseconds(duration, ThetaTop::lanes(), [&] {
    for (double& t : times.high) t += 1;
    bodies.at(times, states);
  });
}

}  // namespace

int main(int, char** argv) {
  const int repeats = std::stoi(argv[1]);
  const double duration = std::stod(argv[2]);
  const int lanes = ThetaTop::lanes();
  const std::string registers = "registers of " + std::to_string(lanes);
  const double bound = lanes == 8 ? 1 / 4. : lanes == 4 ? 1 / 2.5 : 1;
  bench::Comparison alone{"exact, N = 3, a state alone", "ns", "Jacobi's formula, extended", 1},
      one_body{"exact, N = 3, " + registers + ", one body", "ns a state", "alone", bound},
      side_by_side{"exact, N = 3, " + registers + ", side by side", "ns a state", "alone", bound};
  for (int i = 0; i < repeats; ++i) {
    TopInTime top = top_of(static_cast<unsigned>(i + 1));
    ThetaTops tops;
    for (int lane = 0; lane < lanes; ++lane)
      tops.put(lane, *top_of(static_cast<unsigned>(i + lane + 1)).theta());
    const testing::RandomTop given(static_cast<unsigned>(10 * (i + 1)));
    const EulerTop<long double> euler(PrincipalMoments3<long double>(given.lambda),
                                      given.x.cast<long double>());
    std::mt19937_64 generator(1);
    const auto any = [&] { return static_cast<double>(generator() >> 40); };
    volatile double sum = 0;
    const double before =
        nanoseconds(duration, 1, [&] { sum = static_cast<double>(euler.at(0.1L * any())(0)); });
    const double state = nanoseconds(duration, 1, [&] { sum = top.at(any(), 0.1)(0); });
    alone.add(state, before);
    one_body.add(in_lanes(duration, *top.theta()), state);
    side_by_side.add(in_lanes(duration, tops), state);
  }
  for (const auto* row : {&alone, &one_body, &side_by_side}) bench::report(*row);
}
