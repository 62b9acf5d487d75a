#include "engine/scene/near_name.h"

#include <gtest/gtest.h>

namespace stiefel {
namespace {

const std::vector<std::string> fields = {"inertia_tensor", "moments", "attitude",
                                         "angular_velocity"};
const std::vector<std::string> methods = {"variational", "preprocessed_variational", "rk4",
                                          "gauss4", "munthe_kaas4"};

TEST(NameDistance, CountsEditsAndExchangesOfNeighbours) {
  EXPECT_EQ(name_distance("", ""), 0u);
  EXPECT_EQ(name_distance("", "step"), 4u);
  EXPECT_EQ(name_distance("step", ""), 4u);
  EXPECT_EQ(name_distance("step", "step"), 0u);
  EXPECT_EQ(name_distance("stp", "step"), 1u);
  EXPECT_EQ(name_distance("steep", "step"), 1u);
  EXPECT_EQ(name_distance("stop", "step"), 1u);
  EXPECT_EQ(name_distance("setp", "step"), 1u);
  EXPECT_EQ(name_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(name_distance("Rigid-Body", "rigid_body"), 0u);
}

TEST(NameDistance, IsSymmetric) {
  for (const std::string a : {"moments", "attitude", "inertia", "ab", "ba", ""})
    for (const std::string& b : fields) EXPECT_EQ(name_distance(a, b), name_distance(b, a));
}

TEST(NearName, FindsAMisspeltName) {
  EXPECT_EQ(near_name("inertia_tensr", fields), "inertia_tensor");
  EXPECT_EQ(near_name("atitude", fields), "attitude");
  EXPECT_EQ(near_name("AngularVelocity", fields), "angular_velocity");
  EXPECT_EQ(near_name("mometns", fields), "moments");
  EXPECT_EQ(near_name("rk5", methods), "rk4");
  EXPECT_EQ(near_name("munthe-kaas4", methods), "munthe_kaas4");
}

TEST(NearName, FindsABeginningAndWhatAddsToAName) {
  EXPECT_EQ(near_name("var", methods), "variational");
  EXPECT_EQ(near_name("munthe", methods), "munthe_kaas4");
  EXPECT_EQ(near_name("moments_in_kg", fields), "moments");
  EXPECT_EQ(near_name("va", methods), std::nullopt) << "two letters are a guess";
}

TEST(NearName, TakesTheNearest) {
  const std::vector<std::string> known = {"symmetric_rigid_body", "symmetric", "rigid_body"};
  EXPECT_EQ(near_name("symetric", known), "symmetric");
  EXPECT_EQ(near_name("symmetric_rigid", known), "symmetric_rigid_body");
}

TEST(NearName, LeavesFarNamesAlone) {
  EXPECT_EQ(near_name("mass", fields), std::nullopt);
  EXPECT_EQ(near_name("", fields), std::nullopt);
  EXPECT_EQ(near_name("step", std::vector<std::string>{}), std::nullopt);
  EXPECT_EQ(near_name("R", std::vector<std::string>{"Q", "M"}), std::nullopt)
      << "every letter is one edit from every other";
  EXPECT_EQ(near_name(std::string(1'000'000, 'x'), fields), std::nullopt);
}

TEST(NearName, TakesItemsThatHaveAName) {
  struct Item {
    std::string_view name;
    int number;
  };
  const std::vector<Item> items = {{"rigid_body", 1}, {"stiefel", 2}};
  EXPECT_EQ(near_name("stifel", items, &Item::name), "stiefel");
  EXPECT_EQ(did_you_mean("stifel", items, &Item::name), "; did you mean stiefel?");
  EXPECT_EQ(did_you_mean("pendulum", items, &Item::name), "");
}

}  // namespace
}  // namespace stiefel
