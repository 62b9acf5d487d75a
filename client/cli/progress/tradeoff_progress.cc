#include "client/cli/progress/tradeoff_progress.h"

#include <algorithm>
#include <cmath>

namespace stiefel::cli {
namespace {

/// The expected points of a curve until the first curve is complete.
constexpr double usual_points = 8;

bool same_curve(const v1::Method& a, const v1::Method& b) {
  return a.name() == b.name() && a.order() == b.order() && a.arithmetic() == b.arithmetic() &&
         a.scalar() == b.scalar();
}

std::string name(const v1::Method& method) {
  std::string text = method.name();
  if (method.order() > 0) text.append(" ").append(std::to_string(method.order()));
  text.append(", ").append(method.arithmetic());
  if (method.scalar() == "float") text += ", float";
  return text;
}

}  // namespace

void TradeoffProgress::take(const v1::MeasureTradeoffResponse& part) {
  if (part.has_setup()) setup_ = part.setup();
  if (!part.has_point()) return;
  if (curves_ == 0 || !same_curve(last_, part.point().method())) {
    ++curves_;
    before_last_ = points_;
    last_ = part.point().method();
  }
  ++points_;
}

/// Returns the expected number of all points. The present curve counts with the mean of the
/// complete ones, or with one point more than it has already if that is more.
double TradeoffProgress::expected() const {
  const double complete = std::max(0, curves_ - 1);
  const double mean = complete > 0 ? before_last_ / complete : usual_points;
  const double in_hand = points_ - before_last_;
  const double this_curve = curves_ == 0 ? 0 : std::max(mean, in_hand + 1);
  const double to_come = std::max(0.0, static_cast<double>(setup_->curves()) - curves_);
  return before_last_ + this_curve + to_come * mean;
}

std::string TradeoffProgress::points() const {
  return std::to_string(points_) + " of about " + std::to_string(std::lround(expected())) +
         " points";
}

std::string TradeoffProgress::line(double seconds, const Room& room) const {
  if (!setup_) return cut("solving the reference, " + duration(seconds), room.columns);
  const double fraction = expected() > 0 ? points_ / expected() : 0;
  const std::string gap = room.terminal ? "  " : ", ";
  const std::string curve =
      ", curve " + std::to_string(curves_) + " of " + std::to_string(setup_->curves());
  std::string eta, of;
  if (points_ > 0) eta = gap + "ETA " + duration(seconds * (1 / fraction - 1));
  if (curves_ > 0) of = gap + name(last_);
  // Takes the longest line that fits: the name is left out first; percentage and ETA stay.
  constexpr int percentage = 7;
  for (const std::string& words :
       {points() + curve + eta + of, points() + curve + eta, points() + eta}) {
    if (static_cast<int>(words.size()) + percentage <= room.columns)
      return with_bar(fraction, words, room);
  }
  return with_bar(fraction, eta.empty() ? points() : eta.substr(gap.size()), room);
}

std::string TradeoffProgress::how_far() const {
  return setup_ ? "after " + points() : "before the first point";
}

MeasuringLine::MeasuringLine() : line_([this](const Room& room) { return text(room); }) {}

void MeasuringLine::take(const v1::MeasureTradeoffResponse& part) {
  const std::lock_guard lock(mutex_);
  if (part.has_setup()) start_ = std::chrono::steady_clock::now();
  progress_.take(part);
}

std::string MeasuringLine::how_far() const {
  const std::lock_guard lock(mutex_);
  return progress_.how_far();
}

std::string MeasuringLine::text(const Room& room) const {
  const std::lock_guard lock(mutex_);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  return progress_.line(elapsed.count(), room);
}

}  // namespace stiefel::cli
