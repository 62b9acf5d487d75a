#include "engine/numbers/number_128.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/linalg/quadruple.h"

namespace stiefel {
namespace {

using Quadruple = testing::Quad;

Quadruple exactly(const Number128& x) {
  const auto high = static_cast<long double>(x);
  return Quadruple(high) + Quadruple(static_cast<long double>(x - high));
}

/// Numbers of random size and sign with about 107 bits.
class Numbers {
 public:
  Number128 next(double range = 40) {
    const double high = std::ldexp(part_(random_), static_cast<int>(range * part_(random_)));
    return high * (1 + Number128(part_(random_) * 0x1p-54));
  }

 private:
  std::mt19937_64 random_{1};
  std::uniform_real_distribution<double> part_{-1, 1};
};

void expect_near(const Number128& found, const Quadruple& expected, const Quadruple& scale) {
  EXPECT_LE(abs(exactly(found) - expected), 0x1p-109 * abs(scale));
}

TEST(Number128, OperationsHaveThePrecisionOfQuadruple) {
  Numbers numbers;
  for (int k = 0; k < 10'000; ++k) {
    const Number128 a = numbers.next(),
                    b = k % 3 == 0 ? a * (1 + numbers.next() * 1e-30) : numbers.next();
    const Quadruple x = exactly(a), y = exactly(b);
    expect_near(a + b, x + y, abs(x) + abs(y));
    expect_near(a - b, x - y, abs(x) + abs(y));
    expect_near(a * b, x * y, x * y);
    expect_near(a / b, x / y, x / y);
    expect_near(sqrt(abs(a)), sqrt(abs(x)), sqrt(abs(x)));
    EXPECT_TRUE(a == b || a < b || b < a);
    EXPECT_FALSE(a < b && y < x);
    EXPECT_FALSE(b < a && x < y);
    EXPECT_EQ(static_cast<double>(a), static_cast<double>(x));
    EXPECT_EQ(static_cast<double>(a - a), 0);
    EXPECT_TRUE(exactly(a.rounded(113)) == x);
  }
}

/// What no operation rounds: the separatrix is found by such a difference.
TEST(Number128, SumsOfNumbersThatNearlyCancelAreExact) {
  Numbers numbers;
  for (int k = 0; k < 10'000; ++k) {
    const Number128 a = numbers.next(), b = a * (1 + Number128(std::ldexp(1., -k % 64)));
    EXPECT_TRUE(a + (b - a) == b);
    EXPECT_TRUE(-(a - b) == b - a);
  }
}

TEST(Number128, FunctionsHaveThePrecisionOfQuadruple) {
  Numbers numbers;
  for (int k = 0; k < 10'000; ++k) {
    const Number128 a = numbers.next(), part = numbers.next(0), exponent = 100 * part;
    const Quadruple x = exactly(a), y = exactly(part), z = exp(exactly(exponent));
    expect_near(atan(a), atan(x), atan(x));
    expect_near(exp(exponent), z, z * (1 + abs(exactly(exponent))));
    const auto [cosine, sine] = cosine_sine(part);
    expect_near(cosine, cos(y), 1);
    expect_near(sine, sin(y), sin(y));
  }
}

TEST(Number128, ConvertsEveryFiniteNumber) {
  for (const double x : {0., 1., -3., 0x1.fffffffffffffp1023, 0x1p-1022, 0x1p-1074, -0x1.8p-1060}) {
    EXPECT_EQ(static_cast<double>(Number128(x)), x);
    EXPECT_EQ(static_cast<long double>(Number128(static_cast<long double>(x))), x);
  }
  EXPECT_EQ(static_cast<double>(Number128(std::int64_t{-1} << 62)), -0x1p62);
  EXPECT_EQ(static_cast<double>(Number128(1) / 0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(static_cast<double>(sqrt(Number128(-1))), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(sqrt(Number128(0)) == 0);
}

}  // namespace
}  // namespace stiefel
