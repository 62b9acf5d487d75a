// Where the command says that a fault is: in the file, or in the option that was given.
#include "client/cli/origin.h"

#include <gtest/gtest.h>

namespace stiefel::cli {
namespace {

TEST(Origin, AFieldOfTheSceneIsInTheFile) {
  const Origin run{.file = "a.json", .options = {{"to", "--to"}, {"fields", "--fields"}}};
  EXPECT_EQ(run.place("scene.initial.Q[0,1]"), "a.json: initial.Q[0,1]");
  EXPECT_EQ(run.place("scene.to"), "a.json: to") << "no option of that name is meant";
  EXPECT_EQ(run.place("scene"), "a.json");
  EXPECT_EQ(run.place("to"), "--to");
  EXPECT_EQ(run.place("fields[1]"), "--fields[1]");
  EXPECT_EQ(run.place("epsilon"), "epsilon") << "of the request, and of no option";
}

TEST(Origin, ABlockThatStandsForAnotherHasTheNameInTheFile) {
  const Origin run{.file = "a.json", .renamed = {{"initial.M", "initial.Omega"}}};
  EXPECT_EQ(run.place("scene.initial.M"), "a.json: initial.Omega");
  EXPECT_EQ(run.place("scene.initial.Q"), "a.json: initial.Q");
}

TEST(Origin, AFieldOfAWholeRequestIsInTheFile) {
  const Origin connect{.file = "a.json", .whole_request = true};
  EXPECT_EQ(connect.place("pairs[0].Q_0.rows"), "a.json: pairs[0].Q_0.rows");
  const Origin single{.file = "a.json", .whole_request = true, .single_pair = true};
  EXPECT_EQ(single.place("pairs[0].Q_0.rows"), "a.json: Q_0.rows");
  EXPECT_EQ(single.place("inertia[1]"), "a.json: inertia[1]");
}

}  // namespace
}  // namespace stiefel::cli
