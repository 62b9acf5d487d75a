// A session as rows of a store, and back.
#include "server/calls/durability.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>

#include "tests/server/scene_cases.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/every_pair.h"

namespace stiefel::test {
namespace {

TEST(StoredSession, KeepsTheBitsOfEverySystemAndMethod) {
  const auto clock = std::make_shared<const server::Clock>(&std::chrono::steady_clock::now);
  int number = 0;
  for (const auto& [system, method, N] : stiefel::testing::every_pair()) {
    const auto given = stiefel::testing::any_scene(system, method, 1, 0.02, N);
    const auto scene = Scene::resolve(given);
    ASSERT_TRUE(scene) << system << " " << method;
    std::optional<Choice> choice;
    if (number++ % 2 && scene->description().method)
      choice = {*scene->description().method, 0.1, 3, 0.05, "for a reason\nof two lines"};
    const server::RegisteredSession session(server::Principal{"p"}, "a", *scene, choice, clock,
                                            server::MemoryBudget::unlimited());
    const auto again = server::from_row({server::to_row(session), ""}, clock);
    ASSERT_TRUE(again) << system << " " << method << ": " << again.error();
    EXPECT_EQ((*again)->identity(), session.identity()) << system << " " << method;
    EXPECT_EQ((*again)->owner(), session.owner());
    EXPECT_EQ((*again)->create_time(), session.create_time());
    const std::optional<Choice>& read = (*again)->choice();
    ASSERT_EQ(read.has_value(), choice.has_value());
    EXPECT_TRUE(!read || (read->reason == choice->reason && read->error == 0.05 &&
                          read->method.name == choice->method.name));
  }
  EXPECT_GT(number, 30);
}

TEST(StoredSession, OfAnotherSceneIsNotTakenForIt) {
  const auto clock = std::make_shared<const server::Clock>(&std::chrono::steady_clock::now);
  const server::RegisteredSession session({}, "a", scene(), {}, clock,
                                          server::MemoryBudget::unlimited());
  auto row = server::to_row(session);
  row.identity[0] ^= 1;
  EXPECT_FALSE(server::from_row({row, ""}, clock));
  row.numerics_id = "another build";  // whose scenes may have more fields
  EXPECT_TRUE(server::from_row({row, ""}, clock));
  row.scene = "no message";
  EXPECT_FALSE(server::from_row({row, ""}, clock));
}

}  // namespace
}  // namespace stiefel::test
