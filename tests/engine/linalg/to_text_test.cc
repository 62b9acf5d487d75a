#include "engine/numbers/to_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace stiefel {
namespace {

TEST(ToText, IsTheShortestThatReadsBack) {
  EXPECT_EQ(to_text(0.1), "0.1");
  EXPECT_EQ(to_text(1e-9), "1e-09");
  EXPECT_EQ(to_text(1e-8), "1e-08");
  EXPECT_EQ(to_text(-0.0), "-0");
  EXPECT_EQ(to_text(100.0), "100");
  EXPECT_EQ(to_text(std::nan("")), "nan");
  EXPECT_EQ(to_text(-std::numeric_limits<double>::infinity()), "-inf");
  for (double x = 1 / 3.0; std::isnormal(x); x *= -0.0123) {
    EXPECT_EQ(std::strtod(to_text(x).c_str(), nullptr), x);
    EXPECT_LE(to_text(x).size(), 24u);
  }
}

}  // namespace
}  // namespace stiefel
