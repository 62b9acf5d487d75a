// Statistics, against the samples themselves and the drifts that Diagnose has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "engine/motion/invariant_list.h"
#include "stiefel/diagnosis.h"
#include "stiefel/simulation.h"
#include "tests/engine/summary/finished_summary.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using namespace testing;

TEST(Summary, IsThatOfTheSamples) {
  const Scene scene = random_scene(3, 4, 0.2, "rk4");
  const SummaryDescription what = everything(5, 1002, 7);
  const Done done = run(scene, what);
  const auto M = samples(scene, "M", what);
  const auto start = make_simulation(scene)->get("M");
  EXPECT_EQ(done["samples"].counts.front(), static_cast<std::int64_t>(M.size()));
  for (std::size_t i = 0; i < 9; ++i) {
    std::vector<double> x;
    for (const auto& sample : M) x.push_back(sample[i]);
    EXPECT_EQ(done["M.last"].numbers[i], x.back());
    EXPECT_EQ(done["M.min"].numbers[i], std::ranges::min(x));
    EXPECT_EQ(done["M.max"].numbers[i], std::ranges::max(x));
    const auto n = static_cast<long double>(x.size());
    long double sum = 0, squares = 0, drift = 0;
    std::int64_t changes = 0, sign = 0;
    std::vector<std::int64_t> bins(4);
    for (const double value : x) {
      sum += value;
      squares += static_cast<long double>(value) * value;
      drift = std::max<long double>(drift, std::abs(value - start(i / 3, i % 3)));
      const int now = (value > 0) - (value < 0);
      if (now != 0 && sign != 0 && now != sign) ++changes;
      if (now != 0) sign = now;
      for (std::size_t bin = 0; bin < 4; ++bin) {
        const auto& e = what.quantities[1].edges;
        if (value >= e[bin] && (value < e[bin + 1] || (bin == 3 && value == e[4]))) ++bins[bin];
      }
    }
    EXPECT_NEAR(done["M.mean"].numbers[i], static_cast<double>(sum / n), 1e-16);
    EXPECT_NEAR(done["M.rms"].numbers[i], static_cast<double>(std::sqrt(squares / n)), 2e-16);
    EXPECT_EQ(done["M.sign_changes"].counts[i], changes);
    EXPECT_EQ(done["M.drift"].numbers[i], static_cast<double>(drift));
    EXPECT_TRUE(std::ranges::equal(std::span(done["M.histogram"].counts).subspan(4 * i, 4), bins));
    std::ranges::sort(x);
    const std::size_t middle = (x.size() - 1) / 2;
    const double median =
        x.size() % 2 == 1 ? x[middle] : x[middle + 1] - (x[middle + 1] - x[middle]) * 0.5;
    EXPECT_EQ(done["M.quantiles"].numbers[i], median);
  }
}

/// Of every invariant the bits of the largest drift that Diagnose has at a sample.
TEST(Summary, HasTheLargestDriftThatDiagnoseHas) {
  for (const char* method : {"rk4", "preprocessed_variational", "exact"})
    for (const int N : {3, 4}) {
      if (N == 4 && std::string_view(method) != "rk4") continue;
      const Scene scene = random_scene(N, 7, 0.2, method);
      SummaryDescription what{.to = 60, .every = 3};
      const std::vector<std::string> names = {"energy", "spatial_momentum", "casimirs"};
      for (const auto& name : names)
        what.quantities.push_back({name, {Statistic::drift, Statistic::last}, {}, {}});
      const Done done = run(scene, what);
      for (const auto& name : names) {
        const auto simulation = make_simulation(scene);
        std::vector<double> largest, last;
        for (std::int64_t step = 0; step <= 60; step += 3) {
          const Diagnosis at = diagnose(scene, *simulation, std::vector{name});
          largest.resize(at.invariants.size());
          last.clear();
          for (std::size_t i = 0; i < largest.size(); ++i) {
            largest[i] = std::max(largest[i], at.invariants[i].drift());
            last.push_back(static_cast<double>(at.invariants[i].value));
          }
          simulation->advance(3);
        }
        EXPECT_EQ(done[name + ".drift"].numbers, largest) << name << " " << method;
        EXPECT_EQ(done[name + ".last"].numbers, last) << name << " " << method;
      }
    }
}

}  // namespace
}  // namespace stiefel
