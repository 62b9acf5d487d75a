#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

#include "client/cli/progress/status_line.h"
#include "stiefel/v1/tradeoff.pb.h"

namespace stiefel::cli {

/// How far a trade-off has come. A curve is a method with its order, arithmetic and scalar; how
/// many there are is known from the start, how many points each will have is not, so the number of
/// all points is estimated: those measured, and for each curve to come the mean of those before it.
class TradeoffProgress {
 public:
  void take(const v1::MeasureTradeoffResponse& part);

  /// "[===    ]  30 %  41 of about 137 points, curve 7 of 23  ETA 0:12  variational 4, plain",
  /// `seconds` after the first point was begun; before it "solving the reference".
  std::string line(double seconds, const Room& room) const;

  /// "after 41 of about 137 points".
  std::string how_far() const;

 private:
  double expected() const;
  std::string points() const;

  std::optional<v1::TradeoffSetup> setup_;
  v1::Method last_;
  int points_ = 0;       ///< measured
  int curves_ = 0;       ///< begun
  int before_last_ = 0;  ///< points of the curves that are complete
};

/// The status line of a trade-off while it is measured. Thread-safe.
class MeasuringLine {
 public:
  MeasuringLine();
  void take(const v1::MeasureTradeoffResponse& part);
  std::string how_far() const;

 private:
  std::string text(const Room& room) const;

  mutable std::mutex mutex_;
  TradeoffProgress progress_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  StatusLine line_;  // last: its thread uses the others
};

}  // namespace stiefel::cli
