#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "stiefel/catalogue.h"
#include "tests/support/surveys/recommendation_survey.h"

namespace stiefel {
namespace {

struct Block {
  std::string system;
  unsigned first;
};
void PrintTo(const Block& block, std::ostream* out) { *out << block.system << block.first; }

constexpr unsigned scenes = 100, in_a_block = 10;

std::vector<Block> blocks() {
  std::vector<Block> all;
  for (const auto& system : catalogue().systems)
    for (unsigned first = 1; !system.discrete && first <= scenes; first += in_a_block)
      all.push_back({std::string(system.name), first});
  return all;
}

class RecommendedMethodSurvey : public ::testing::TestWithParam<Block> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, RecommendedMethodSurvey, ::testing::ValuesIn(blocks()),
                         [](const auto& which) {
                           return which.param.system + "_" + std::to_string(which.param.first);
                         });

/// 100 random scenes of each system without a method, N ≤ 16, h‖Ω‖ = 0.05 … 0.3: within 1e-8 (times
/// the condition on V(n, N)) after 100 rotations, at most_cost times the cheapest entry's work at
/// most.
TEST_P(RecommendedMethodSurvey, IsAccurateAndCheap) {
  const auto& [system, first] = GetParam();
  for (unsigned seed = first; seed < first + in_a_block; ++seed) {
    const auto outcome =
        testing::survey_recommendation(testing::scene_without_method(system, seed, 16));
    std::cout << seed << ": " << outcome.scene << ", " << outcome.method << ": error "
              << outcome.error << " (reference " << outcome.reference_error << "), condition "
              << outcome.condition << ", cost " << outcome.cost << " x " << outcome.cheapest
              << std::endl;
    EXPECT_LE(outcome.error, 1e-8 * outcome.condition);
    EXPECT_LE(outcome.cost, testing::most_cost(outcome));
  }
}

}  // namespace
}  // namespace stiefel
