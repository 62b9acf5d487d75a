#include "engine/numbers/double_word.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/linalg/quadruple.h"

namespace stiefel {
namespace {

using Quadruple = testing::Quad;

Quadruple exactly(const DoubleWord<double>& x) { return Quadruple(x.high) + Quadruple(x.low); }

/// A double word of random size and sign, its low word anything up to some units of the last place.
class Words {
 public:
  DoubleWord<double> next() {
    const double high = std::ldexp(part_(random_), static_cast<int>(40 * part_(random_)));
    return {high, part_(random_) * high * 0x1p-51};
  }

 private:
  std::mt19937_64 random_{1};
  std::uniform_real_distribution<double> part_{-1, 1};
};

void expect_near(const DoubleWord<double>& found, const Quadruple& expected,
                 const Quadruple& scale) {
  EXPECT_LE(abs(exactly(found) - expected), 0x1p-98 * abs(scale));
}

TEST(DoubleWord, OperationsHaveNearlyTwiceThePrecision) {
  Words words;
  for (int k = 0; k < 10'000; ++k) {
    const auto a = words.next(), b = words.next();
    const Quadruple x = exactly(a), y = exactly(b);
    expect_near(a + b, x + y, abs(x) + abs(y));
    expect_near(a - b, x - y, abs(x) + abs(y));
    expect_near(a.high + b, a.high + y, abs(x) + abs(y));
    expect_near(a * b, x * y, x * y);
    expect_near(a.high * b, a.high * y, x * y);
    expect_near(a / b, x / y, x / y);
    const auto positive = a.high < 0 ? -a : a;
    expect_near(sqrt(positive), sqrt(exactly(positive)), sqrt(exactly(positive)));
  }
}

TEST(DoubleWord, NormalizedIsTheSameNumber) {
  Words words;
  for (int k = 0; k < 10'000; ++k) {
    const auto a = words.next(), n = a.normalized();
    EXPECT_EQ(exactly(n), exactly(a));
    EXPECT_EQ(n.high + n.low, n.high);
  }
}

TEST(DoubleWord, TakesTheBitsOfALongDouble) {
  const long double x = 1 / 3.0L;
  const DoubleWord<double> word(x);
  EXPECT_EQ(static_cast<long double>(word.high) + word.low, x);
}

TEST(DoubleWord, ProductsByHalvesAreExact) {
  Words words;
  for (int k = 0; k < 10'000; ++k) {
    const double a = words.next().high, b = words.next().high;
    double product, error;
    two_product(a, b, product, error);
    EXPECT_EQ(product, a * b);
    EXPECT_EQ(error, std::fma(a, b, -product));
  }
}

}  // namespace
}  // namespace stiefel
