#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "client/cli/progress/progress.h"
#include "client/cli/sinks/sink.h"

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

TEST(ProgressLine, KeepsWithinItsColumnsAndKeepsPercentageAndTimeLeft) {
  constexpr std::int64_t to = std::int64_t{1} << 53;
  for (const std::int64_t step : {std::int64_t{0}, to / 3, to})
    for (const int columns : {24, 40, 79}) {
      const std::string line = progress_line(step, to, 1e5, {columns, true});
      EXPECT_LE(line.size(), static_cast<std::size_t>(columns)) << line;
      EXPECT_NE(line.find(" %"), std::string::npos) << line;
      EXPECT_EQ(line.find("ETA ") != std::string::npos, step > 0) << line;
    }
}

}  // namespace
}  // namespace stiefel::cli
