#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "client/cli/progress/progress.h"
#include "client/cli/progress/tradeoff_progress.h"
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
  constexpr std::int64_t far = std::int64_t{1} << 53;
  for (const std::int64_t to : {std::int64_t{1}, std::int64_t{1'000'000'000'000}, far}) {
    for (const std::int64_t step : {std::int64_t{0}, to / 3, to - 1, to}) {
      for (const double seconds : {1e-3, 1.0, 1e5, 1e12}) {
        for (int columns = 24; columns <= 79; ++columns) {
          for (const bool in_place : {true, false}) {
            const std::string line = progress_line(step, to, seconds, {columns, in_place});
            EXPECT_LE(line.size(), static_cast<std::size_t>(columns)) << line;
            EXPECT_NE(line.find(" %"), std::string::npos) << line;
            EXPECT_EQ(line.find("ETA ") != std::string::npos, step > 0) << line;
          }
        }
      }
    }
  }
  for (int columns = 0; columns < 24; ++columns)
    EXPECT_LE(progress_line(far / 2, far, 1, {columns, true}).size(),
              static_cast<std::size_t>(columns));
}

v1::MeasureTradeoffResponse point(const std::string& method, int order) {
  v1::MeasureTradeoffResponse part;
  auto& made = *part.mutable_point()->mutable_method();
  made.set_name(method);
  made.set_order(static_cast<std::uint32_t>(order));
  made.set_arithmetic("plain");
  return part;
}

TEST(TradeoffProgress, CountsPointsAndCurvesAndEstimatesTheRest) {
  TradeoffProgress progress;
  EXPECT_EQ(progress.how_far(), "before the first point");
  v1::MeasureTradeoffResponse setup;
  setup.mutable_setup()->set_curves(4);
  progress.take(setup);
  for (int k = 0; k < 6; ++k) progress.take(point("rk4", 4));
  progress.take(point("gauss4", 4));
  // Six points of the curve before, as many expected of each of the other three.
  EXPECT_EQ(progress.how_far(), "after 7 of about 24 points");
  EXPECT_EQ(progress.line(7, {100, false}),
            "29 %, 7 of about 24 points, curve 2 of 4, ETA 0:17, gauss4 4, plain");
  for (int k = 0; k < 9; ++k) progress.take(point("gauss4", 4));
  EXPECT_EQ(progress.how_far(), "after 16 of about 29 points") << "at least one more of this curve";
}

}  // namespace
}  // namespace stiefel::cli
