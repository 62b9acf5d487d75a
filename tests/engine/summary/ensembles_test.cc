// Summaries of ensembles: of each member, and over the members.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "stiefel/simulation.h"
#include "tests/engine/summary/finished_summary.h"
#include "tests/support/scenes/ensemble_of.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using namespace testing;

std::vector<SceneDescription> bodies(int count, const std::string& method, double step) {
  std::vector<SceneDescription> scenes;
  for (int b = 0; b < count; ++b)
    scenes.push_back(
        testing::description(RandomBody(3, 100 + static_cast<unsigned>(b)), step, method));
  return scenes;
}

/// A body whose rk4 ends within 900 steps.
SceneDescription diverging(SceneDescription scene) {
  for (unsigned seed = 1; seed < 100; ++seed)
    for (double rate = 10; rate < 100; rate *= 1.3) {
      RandomBody body(3, seed, 40);
      scene.inertia = {body.lambda.begin(), body.lambda.end()};
      scene.initial["M"] = RowMatrix(body.M * rate);
      const auto simulation = make_simulation(resolved(scene));
      if (!simulation->advance(900).reached() && simulation->step() > 10) return scene;
    }
  throw std::logic_error("none of them diverges");
}

/// Many members go in parts, one after another.
TEST(SummaryOfAnEnsemble, OfManyMembersIsTheSameInPartsAndResumed) {
  limit_threads(1);
  auto scenes = bodies(300, "rk4", 0.3);
  scenes[7] = scenes[290] = diverging(scenes[7]);
  const Scene ensemble = resolved(testing::ensemble_of(scenes));
  const auto what = everything(3, 900, 11);
  const auto whole = run(ensemble, what, 900).bits();
  EXPECT_EQ(run(ensemble, what, 1).bits(), whole);
  const auto summary = prepare(ensemble, what);
  int in_parts = 0, resumed = 0;
  while (!summary->done()) {
    const std::int64_t before = summary->step();
    summary->advance(40, what.to);
    EXPECT_GE(summary->step(), before);
    EXPECT_TRUE(summary->aligned() || summary->step() == before);
    if (!summary->aligned()) {
      ++in_parts;
      continue;
    }
    const auto next = prepare(ensemble, what);
    ASSERT_TRUE(next->restore(summary->save()));
    EXPECT_EQ(next->save(), summary->save());
    EXPECT_EQ(finish(*next, 7).bits(), whole) << "from step " << next->step();
    ++resumed;
  }
  EXPECT_GE(in_parts, 3);
  EXPECT_GE(resumed, 3);
  EXPECT_EQ(finish(*summary).bits(), whole);
}

/// What a simulation of the ensemble has computed serves the summaries after it.
TEST(SummaryOfAnEnsemble, IsTheSameAfterASimulation) {
  for (const char* method : {"rk4", "variational", "exact"}) {
    auto scenes = bodies(21, method, 0.3);
    scenes[5].initial["M"].values *= 1e-210;  // its products are too small to be packed
    const Scene ensemble = resolved(testing::ensemble_of(scenes));
    const auto what = everything(3, 90, 11);
    const auto expected = run(ensemble, what).bits();
    const auto simulation = make_simulation(ensemble);
    ASSERT_TRUE(simulation->advance(7).reached());
    const auto summary = Summary::prepare(ensemble, what, simulation.get()).value();
    EXPECT_EQ(finish(*summary).bits(), expected) << method;
  }
}

/// Events and states at times are reported in the order of steps, once all members have passed
/// them.
TEST(SummaryOfAnEnsemble, OfManyMembersFindsTheSameEventsInParts) {
  limit_threads(1);
  auto scenes = bodies(300, "rk4", 0.3);
  scenes[7] = scenes[290] = diverging(scenes[7]);
  const Scene ensemble = resolved(testing::ensemble_of(scenes));
  auto what = with_all(everything(3, 900, 11), ensemble.step());
  what.events[1].terminal = false;
  const Done whole = run(ensemble, what, 900);
  EXPECT_FALSE(whole.events.empty());
  EXPECT_FALSE(whole.states.empty());
  for (const int slice : {2, 40}) EXPECT_EQ(run(ensemble, what, slice).bits(), whole.bits());
}

/// Those that were stopped in a part of them go on from where each is.
TEST(SummaryOfAnEnsemble, OfManyMembersGoesOnAfterAStop) {
  const Scene ensemble = resolved(testing::ensemble_of(bodies(300, "rk4", 0.1)));
  SummaryDescription what{.to = 500};
  what.quantities = {{"energy", {Statistic::drift}}};
  const auto whole = run(ensemble, what, 500).bits();
  const auto summary = prepare(ensemble, what);
  std::stop_source stop;
  stop.request_stop();
  while (!summary->done()) {
    summary->advance(20, what.to, stop.get_token());
    EXPECT_TRUE(summary->interrupted() && !summary->aligned());
    summary->advance(20, what.to);
    EXPECT_FALSE(summary->interrupted());
  }
  EXPECT_EQ(finish(*summary).bits(), whole);
}

/// Runs the items on the calling thread, the last one first, and counts them.
struct CountingCrew : Crew {
  std::size_t threads_at_hand() override { return 2; }
  void run(std::size_t count, double, Item item, void* context) override {
    for (std::size_t i = count; i-- > 0; ++items) item(context, i);
  }
  std::size_t items = 0;
};

/// The crew of the calling thread advances the groups of members, in any order, with the same bits.
TEST(SummaryOfAnEnsemble, IsTheWorkOfTheCrew) {
  const Scene ensemble = resolved(testing::ensemble_of(bodies(300, "rk4", 0.3)));
  const auto what = everything(0, 900, 11);
  const auto alone = run(ensemble, what, 900).bits();
  CountingCrew crew;
  const CrewOfThisThread here(crew);
  EXPECT_EQ(run(ensemble, what, 900).bits(), alone);
  EXPECT_GE(crew.items, 16u);
}

/// Each member has the numbers that it has alone, those that stop early and the others; whatever
/// the threads.
TEST(SummaryOfAnEnsemble, IsOfEachMemberWhatItIsAlone) {
  for (const char* method : {"preprocessed_variational", "rk4", "exact"}) {
    auto scenes = bodies(21, method, 0.3);
    if (method == std::string_view("rk4")) {
      scenes[7] = diverging(scenes[7]);
      scenes[9] = diverging(scenes[9]);
    }
    const Scene ensemble = resolved(testing::ensemble_of(scenes));
    auto what = with_all(everything(3, 900, 11), ensemble.step());
    what.events[1].terminal = method != std::string_view("rk4");
    std::vector<std::uint64_t> bits;
    for (const int threads : {1, 2, 5}) {
      limit_threads(threads);
      const Done all = run(ensemble, what, threads == 2 ? 10 : 1000);
      if (bits.empty()) bits = all.bits();
      EXPECT_EQ(all.bits(), bits) << method << " with " << threads << " threads";
    }
    limit_threads(2);
    const Done all = run(ensemble, what);
    std::size_t events = 0;
    for (std::size_t b = 0; b < scenes.size(); ++b) {
      const Done one = run(resolved(scenes[b]), what);
      for (std::size_t i = 0; i < one.statistics.size(); ++i) {
        const auto &mine = one.statistics[i], &theirs = all.statistics[i];
        const std::size_t each = mine.numbers.size(), counts = mine.counts.size();
        for (std::size_t k = 0; k < each; ++k)
          EXPECT_EQ(std::bit_cast<std::uint64_t>(theirs.numbers[b * each + k]),
                    std::bit_cast<std::uint64_t>(mine.numbers[k]))
              << method << " " << mine.name << " of member " << b;
        for (std::size_t k = 0; k < counts; ++k)
          EXPECT_EQ(theirs.counts[b * counts + k], mine.counts[k]) << mine.name;
      }
      std::size_t at = 0;
      for (const Event& event : all.events) {
        if (event.member != b) continue;
        ASSERT_LT(at, one.events.size());
        EXPECT_EQ(event.time, one.events[at].time);
        EXPECT_EQ(event.fields, one.events[at++].fields);
      }
      EXPECT_EQ(at, one.events.size());
      events += at;
    }
    EXPECT_EQ(events, all.events.size());
    if (method != std::string_view("rk4")) continue;
    EXPECT_EQ(all.status.outcome, Outcome::not_finite);
    EXPECT_EQ(std::ranges::count_if(all["outcome"].counts, [](auto o) { return o != 0; }), 2);
  }
}

/// The largest drift of the energy is read on a path of its own where nothing else is asked for on
/// the way: it has the bits that it has among other statistics, also after a checkpoint and beside
/// members that end.
TEST(SummaryOfAnEnsemble, ReadsADriftAloneAsAmongOthers) {
  for (const char* method : {"preprocessed_variational", "rk4", "exact"}) {
    auto scenes = bodies(21, method, 0.3);
    if (method == std::string_view("rk4"))
      for (const std::size_t b : {7, 8, 20}) scenes[b] = diverging(scenes[b]);
    const Scene ensemble = resolved(testing::ensemble_of(scenes));
    for (const std::int64_t every : {1, 11}) {
      SummaryDescription among{.from = 3, .to = 900, .every = every};
      for (const double k : {5.0, 17.5, 17.75}) among.times.push_back(k * ensemble.step());
      among.quantities = {{"energy", {Statistic::drift, Statistic::last}},
                          {"quaternion", {Statistic::last}}};
      SummaryDescription alone = among;
      among.quantities[0].statistics.push_back(Statistic::min);
      Done expected = run(ensemble, among);
      std::erase_if(expected.statistics, [](const auto& one) { return one.name == "energy.min"; });
      EXPECT_EQ(run(ensemble, alone).bits(), expected.bits()) << method << " every " << every;
      const auto first = prepare(ensemble, alone);
      Done resumed;
      while (first->step() < 450) {
        first->advance(7, 450);
        resumed.take(*first);
      }
      const auto second = prepare(ensemble, alone);
      ASSERT_TRUE(second->restore(first->save()));
      Done rest = finish(*second, 13);
      rest.states = resumed.states;
      EXPECT_EQ(rest.bits(), expected.bits()) << method << " every " << every;
    }
  }
}

TEST(SummaryOfAnEnsemble, OverTheMembersIsOfAllTheirSamples) {
  const auto scenes = bodies(13, "preprocessed_variational", 0.2);
  const Scene ensemble = resolved(testing::ensemble_of(scenes));
  SummaryDescription what{.to = 200, .every = 5};
  what.quantities = {
      {"M", {Statistic::max, Statistic::mean, Statistic::sign_changes}, {0.25}, {-1, 0, 1}, true}};
  const Done all = run(ensemble, what);
  what.quantities[0].over_members = false;
  std::vector<double> values, largest(9, -1e300);
  long double sum = 0;
  std::int64_t changes = 0, below = 0;
  for (const auto& scene : scenes) {
    const Done one = run(resolved(scene), what);
    for (std::size_t i = 0; i < 9; ++i) largest[i] = std::max(largest[i], one["M.max"].numbers[i]);
    changes += one["M.sign_changes"].counts[1];
    below += one["M.histogram"].counts[2];
    for (const auto& sample : samples(resolved(scene), "M", what)) {
      values.push_back(sample[1]);
      sum += sample[1];
    }
  }
  EXPECT_EQ(all["M.max"].numbers, largest);
  EXPECT_EQ(all["M.sign_changes"].counts[1], changes);
  EXPECT_EQ(all["M.histogram"].counts[2], below);
  EXPECT_NEAR(all["M.mean"].numbers[1],
              static_cast<double>(sum / static_cast<long double>(values.size())), 1e-16);
  std::ranges::sort(values);
  const double position = 0.25 * static_cast<double>(values.size() - 1);
  const auto at = static_cast<std::size_t>(position);
  EXPECT_GE(all["M.quantiles"].numbers[1], values[at]);
  EXPECT_LE(all["M.quantiles"].numbers[1], values[at + 1]);
}

}  // namespace
}  // namespace stiefel
