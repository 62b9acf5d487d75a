#pragma once

#include <chrono>
#include <mutex>
#include <optional>
#include <string>

#include "client/cli/progress/status_line.h"
#include "stiefel/v1/tradeoff.pb.h"

namespace stiefel::cli {

/// How far the measurement of a trade-off is. A curve is a method with its order, arithmetic and
/// scalar. The number of curves is known from the start, the number of their points is not: each
/// curve to come is expected to have as many points as the mean of the complete curves.
class TradeoffProgress {
 public:
  void take(const v1::MeasureTradeoffResponse& part);

  /// Returns "[===    ]  30 %  41 of about 137 points, curve 7 of 23  ETA 0:12  variational 4,
  /// plain", or "solving the reference, 0:03" before the first point is begun. `seconds`: the time
  /// since the first point was begun, or before that since the start.
  std::string line(double seconds, const Room& room) const;

  /// Returns "after 41 of about 137 points".
  std::string how_far() const;

 private:
  double expected() const;
  std::string points() const;

  std::optional<v1::TradeoffSetup> setup_;
  v1::Method last_;
  int points_ = 0;       ///< points measured
  int curves_ = 0;       ///< curves begun
  int before_last_ = 0;  ///< points of the complete curves
};

/// Shows a status line while a trade-off is measured. Thread-safe.
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
  StatusLine line_;  // the last member, because its thread uses the others
};

}  // namespace stiefel::cli
