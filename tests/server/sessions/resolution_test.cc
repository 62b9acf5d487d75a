#include "server/sessions/identity.h"

#include <gtest/gtest.h>

#include "tests/server/scene_cases.h"

namespace stiefel::server {
namespace {

using Names = std::vector<std::string>;

TEST(Difference, OfWhatIsTheSameIsEmpty) {
  const auto found = difference(test::description(), test::description());
  EXPECT_TRUE(found.filled_in.empty());
  EXPECT_TRUE(found.cleared.empty());
}

TEST(Difference, IsWhatResolvingFilledIn) {
  const SceneDescription given = test::description();
  const auto found = difference(given, Scene::resolve(given)->description());
  EXPECT_EQ(found.filled_in, Names{"method"});
  EXPECT_TRUE(found.cleared.empty());
}

TEST(Difference, OfABodyIsOfItsParts) {
  SceneDescription given;
  given.system = "rigid_body";
  given.step = 0.1;
  given.body = BodyDescription{{}, {1, 2, 2.5}, {}, {0.1, 1, 0.1}};
  const auto found = difference(given, resolve_recommending(given)->description());
  EXPECT_EQ(found.filled_in, (Names{"method", "body.attitude"}));
  EXPECT_TRUE(found.fills_in("method.order"));
  EXPECT_TRUE(found.fills_in("body.attitude"));
  EXPECT_FALSE(found.fills_in("body.moments"));
  EXPECT_FALSE(found.fills_in("methods"));
  EXPECT_FALSE(found.fills_in("step"));
}

TEST(Difference, NamesWhatIsGone) {
  SceneDescription resolved = test::description();
  resolved.tolerance.reset();
  SceneDescription given = resolved;
  given.tolerance = 1e-6;
  given.body = BodyDescription{};
  EXPECT_EQ(difference(given, resolved).cleared, (Names{"body", "tolerance"}));
}

TEST(Difference, ComparesBits) {
  SceneDescription given = test::description(), other = given;
  given.initial["M"].values(0, 0) = 0.0;
  other.initial["M"].values(0, 0) = -0.0;
  EXPECT_EQ(difference(given, other).filled_in, Names{"initial"});
}

}  // namespace
}  // namespace stiefel::server
