#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "client/cli/progress.h"
#include "client/cli/sink.h"

namespace stiefel::cli {
namespace {

TEST(AppendNumber, ReadsBackTheSameBits) {
  std::uint64_t state = 1;
  for (int i = 0; i < 10'000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const double number = std::bit_cast<double>(state & ~(std::uint64_t{1} << 62));
    std::string text;
    append_number(text, number);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(std::strtod(text.c_str(), nullptr)),
              std::bit_cast<std::uint64_t>(number))
        << text;
  }
}

TEST(AppendNumber, IsNeverAnInteger) {
  for (const auto& [number, expected] : {std::pair{0.0, "0.0"},
                                         {-0.0, "-0.0"},
                                         {3.0, "3.0"},
                                         {1e22, "1e+22"},
                                         {std::numeric_limits<double>::denorm_min(), "5e-324"}}) {
    std::string text;
    append_number(text, number);
    EXPECT_EQ(text, expected);
  }
}

TEST(ProgressLine, FillsFromEmptyToFull) {
  EXPECT_EQ(progress_line(0, 1000, 0, 4), "[    ]   0 %  step 0 of 1000  0 steps/s");
  EXPECT_EQ(progress_line(500, 1000, 250, 4), "[==  ]  50 %  step 500 of 1000  250 steps/s");
  EXPECT_EQ(progress_line(1000, 1000, 2e6, 4), "[====] 100 %  step 1000 of 1000  2e+06 steps/s");
  EXPECT_EQ(progress_line(0, 0, 0, 4), "[====] 100 %  step 0 of 0  0 steps/s");
}

}  // namespace
}  // namespace stiefel::cli
