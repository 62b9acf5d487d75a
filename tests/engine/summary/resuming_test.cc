// Summaries in parts, from a checkpoint, damaged, refused and stopped.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/engine/summary/finished_summary.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_scene.h"

namespace stiefel {
namespace {

using namespace testing;

TEST(Summary, DoesNotDependOnHowTheStepsAreDivided) {
  for (const char* method : {"preprocessed_variational", "exact", "rk4"}) {
    const Scene scene = random_scene(3, 4, 0.25, method);
    const auto what = with_all(everything(5, 1002, 7), scene.step());
    const auto whole = run(scene, what, 1'000'000).bits();
    for (const std::int64_t steps : {1, 10, 333}) EXPECT_EQ(run(scene, what, steps).bits(), whole);
  }
}

TEST(Summary, ResumesAtAnyStepWithTheSameBits) {
  const Scene scene = random_scene(3, 4, 0.25, "rk4");
  const auto what = with_all(everything(5, 302, 7), scene.step());
  const auto whole = run(scene, what).bits();
  for (std::int64_t at = 0; at < 302; at += 13) {
    const auto first = prepare(scene, what);
    Done done;
    while (first->step() < at) first->advance(50, at);
    done.take(*first);
    const auto second = prepare(scene, what);
    ASSERT_TRUE(second->restore(first->save())) << at;
    EXPECT_EQ(second->step(), first->step());
    EXPECT_EQ(second->save(), first->save());
    Done rest = finish(*second);
    std::ranges::move(rest.events, std::back_inserter(done.events));
    std::ranges::move(rest.states, std::back_inserter(done.states));
    done.statistics = rest.statistics;
    EXPECT_EQ(done.bits(), whole) << at;
  }
}

TEST(Summary, DoesNotTakeDamagedBytes) {
  const Scene scene = random_scene(3, 4, 0.25, "rk4");
  const auto what = with_all(everything(5, 302, 7), scene.step());
  const auto first = prepare(scene, what);
  first->advance(100, 100);
  const std::string saved = first->save();
  for (std::size_t length = 0; length < saved.size(); length += 7)
    EXPECT_FALSE(prepare(scene, what)->restore(std::string_view(saved).substr(0, length)));
  EXPECT_FALSE(prepare(scene, what)->restore(saved + '\0'));
  EXPECT_FALSE(prepare(scene, everything(5, 302, 7))->restore(saved));
}

TEST(Summary, EndsWhenItIsAskedToStop) {
  const Scene scene = random_scene(3, 5, 0.1, "rk4");
  const auto summary = prepare(scene, everything(0, 1000, 1));
  summary->advance(10, 1000);
  EXPECT_FALSE(summary->interrupted());
  std::stop_source stop;
  stop.request_stop();
  summary->advance(10, 1000, stop.get_token());
  EXPECT_TRUE(summary->interrupted());
  EXPECT_FALSE(summary->done());
  summary->cancel();
  EXPECT_TRUE(summary->done());
  EXPECT_EQ(summary->status().outcome, Outcome::cancelled);
}

}  // namespace
}  // namespace stiefel
