#include "server/sessions/server_session.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "server/scheduling/slice.h"
#include "server/sessions/cursor.h"
#include "stiefel/crew.h"
#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

using test::expected_state;
using test::saved;

std::shared_ptr<Session> session_of(const test::Case& which = {}) {
  return std::make_shared<Session>(test::scene(which));
}

/// The state at `to`, a slice of `budget` steps at a time.
std::vector<double> state_at(Session& session, std::int64_t to,
                             std::int64_t budget = std::numeric_limits<std::int64_t>::max()) {
  Cursor walk(session, to);
  while (true) {
    std::int64_t left = budget;
    if (walk.advance(to, left)) break;
  }
  EXPECT_EQ(walk.step(), to);
  return saved(walk.simulation());
}

TEST(Session, GoesOnFromWhereItWas) {
  const auto session = session_of();
  state_at(*session, 100);
  Cursor walk(*session, 150);
  EXPECT_EQ(walk.step(), 100);
  EXPECT_EQ(session->cursor(), 100);
}

TEST(Session, ALongWalkHoldsNobodyUp) {
  const auto session = session_of();
  Cursor long_walk(*session, 1'000'000'000'000);
  std::int64_t budget = slice_steps(session->step_cost());
  const std::int64_t slice = budget;
  EXPECT_FALSE(long_walk.advance(1'000'000'000'000, budget));
  EXPECT_EQ(long_walk.computed_steps(), slice) << "a slice is its steps and no more";
  EXPECT_EQ(state_at(*session, 20), expected_state(session->scene(), 20));
}

TEST(Session, ACancelledWalkStaysAtItsLastGoodState) {
  const auto session = session_of();
  Cursor walk(*session, 1000);
  std::int64_t budget = 10;
  EXPECT_FALSE(walk.advance(1000, budget));
  walk.cancel();
  EXPECT_EQ(walk.run_status().outcome, Outcome::cancelled);
  budget = 10;
  EXPECT_TRUE(walk.advance(1000, budget));
  EXPECT_EQ(saved(walk.simulation()), expected_state(session->scene(), 10));
}

TEST(Session, GoesBackFromACheckpoint) {
  const auto session = session_of();
  const std::int64_t spacing = session->next_checkpoint(0);
  EXPECT_EQ(session->next_checkpoint(spacing - 1), spacing);
  EXPECT_EQ(session->next_checkpoint(spacing), 2 * spacing);
  state_at(*session, 3 * spacing + 7);
  EXPECT_EQ(session->cached_steps(),
            (std::vector<std::int64_t>{0, spacing, 2 * spacing, 3 * spacing}));
  Cursor walk(*session, 2 * spacing + 5);
  EXPECT_EQ(walk.step(), 2 * spacing);
}

/// Runs the items on the calling thread and counts them.
struct CountingCrew : Crew {
  std::size_t threads_at_hand() override { return 2; }
  void run(std::size_t count, double, Item item, void* context) override {
    for (std::size_t i = 0; i < count; ++i, ++items) item(context, i);
  }
  std::size_t items = 0;
};

std::shared_ptr<Session> session_of_many(int members) {
  SceneDescription scene = test::description();
  scene.members = members;
  for (auto& [name, block] : scene.initial) block = RowMatrix(block.values.replicate(members, 1));
  return std::make_shared<Session>(Scene::resolve(scene).value());
}

/// A group of members that was fetched from memory takes many steps, on any thread, before the next
/// group is fetched: as many as there are between two checkpoints.
TEST(Session, AGroupOfMembersTakesManyStepsAtATime) {
  const auto session = session_of_many(20'000);
  CountingCrew crew;
  const CrewOfThisThread here(crew);
  Cursor walk(*session, 501);
  const auto go = [&](std::int64_t to) {
    crew.items = 0;
    for (bool arrived = false; !arrived;) {
      std::int64_t budget = slice_steps(session->step_cost());
      arrived = walk.advance(to, budget);
    }
    EXPECT_EQ(walk.step(), to);
    return crew.items;
  };
  const std::size_t groups = go(1);
  EXPECT_GE(groups, 2'500u);
  const std::size_t times = go(501) / groups;
  EXPECT_LE(times, 10u) << "the groups were fetched for 500 steps";
  EXPECT_GE(times, 1u);
}

/// Whatever ends a walk while some members are ahead of the others.
TEST(Session, MembersGoBackWhenAWalkEndsOnTheWay) {
  limit_threads(1);
  const auto session = session_of_many(300);
  const auto begin = [&](Cursor& walk) {
    std::int64_t budget = 1;
    while (walk.step() == 0) {
      budget = 1;
      EXPECT_FALSE(walk.advance(1000, budget));
    }
    const std::int64_t at = walk.step();
    budget = 1;
    EXPECT_FALSE(walk.advance(1000, budget));
    EXPECT_EQ(walk.step(), at) << "some members are on their way";
    return at;
  };
  {
    Cursor walk(*session, 1000);
    const std::int64_t at = begin(walk);
    walk.suspend();
    walk.cancel();
    EXPECT_EQ(walk.run_status().outcome, Outcome::cancelled);
    EXPECT_EQ(walk.step(), at);
    EXPECT_EQ(saved(walk.simulation()), expected_state(session->scene(), at));
  }
  session->evict();
  {
    Cursor walk(*session, 1000);
    begin(walk);
  }
  EXPECT_EQ(state_at(*session, 20), expected_state(session->scene(), 20));
}

TEST(Session, LargeStatesAreKeptMoreRarely) {
  const auto rate = [](const Session& session) {  // in bytes a second
    const double seconds = 1e-9 * session.step_cost();
    const double bytes = 8.0 * static_cast<double>(session.saved_size());
    return bytes / (seconds * static_cast<double>(session.next_checkpoint(0)));
  };
  for (const int N : {3, 8, 64})
    EXPECT_LE(rate(*session_of({.dimension = N})), 32e6)
        << N << ": twice what is meant, as the spacing is a power of two";
  EXPECT_LE(rate(*session_of({.dimension = 128})), 4e6) << "the cores share a step";
  EXPECT_LE(rate(*session_of_many(20'000)), 4e6);
}

TEST(Session, TheWrongStepEndsTheWalk) {
  SceneDescription wild = test::description();
  wild.step = 40;
  auto scene = Scene::resolve(wild);
  ASSERT_TRUE(scene);
  Session session(*std::move(scene));
  for (int i = 0; i < 2; ++i) {
    Cursor walk(session, 100);
    std::int64_t budget = 1000;
    EXPECT_TRUE(walk.advance(100, budget));
    EXPECT_EQ(walk.run_status().outcome, Outcome::left_domain);
    EXPECT_LT(walk.step(), 100);
  }
}

}  // namespace
}  // namespace stiefel::server
