#pragma once

#include <algorithm>
#include <cmath>

#include "engine/accuracy/series_equations.h"
#include "engine/dense/taylor_motion.h"

namespace stiefel {

/// Taylor series as reference. The distance of two solutions is the error estimate: the second one
/// has series of a lower order and of another length. The factor between their truncation errors is
/// small, so that over thousands of series the estimate stays below the tolerances that double
/// precision can meet.
template <class Series>
class TaylorReference final : public Reference {
 public:
  /// `make(order)` returns the series.
  template <class Make>
  TaylorReference(const Make& make, const SeriesStart<long double>& start, double budget)
      : reported_(start.reported),
        budget_(budget),
        work_(series_work(start.x, order)),
        coarse_work_(series_work(start.x, coarse_order)),
        momentum_rows_(make(order).momentum_rows()),
        fine_(make(order), start.x, epsilon),
        coarse_(make(coarse_order), perturbed_by_rounding(start.x, momentum_rows_),
                coarse_epsilon) {}

  std::optional<Answer> at(double time, const std::stop_token& stop) override {
    // Begins no series that exceeds the budget.
    const auto before = [&](double series) {
      return [&, series] { return stop.stop_requested() || work() + series > budget_; };
    };
    if (!fine_.go_to(time, before(work_)) || !coarse_.go_to(time, before(coarse_work_)))
      return std::nullopt;
    ++answers_;
    MotionState state = present(fine_);
    error_ = std::max({error_, rounding(state), error_of(present(coarse_), state).largest()});
    return Answer{std::move(state), error_};
  }

  std::string description() const override {
    return "Taylor series of order " + std::to_string(order) + " in extended precision";
  }

  double work() const override {
    return static_cast<double>(fine_.series_count()) * work_ +
           static_cast<double>(coarse_.series_count()) * coarse_work_ + answers_ * answer_work();
  }
  /// Both series by Horner's rule, two operations for each coefficient of each number.
  double answer_work() const override {
    return operation_work * 4 * order * static_cast<double>(fine_.state().size());
  }

  /// Predicts the work from the time that the first series spans. If the first series of both
  /// solutions already exceed the budget, returns their work.
  double predicted_work(double time, const std::stop_token& stop) override {
    const double first = work_ + coarse_work_;
    const auto stopped = [&] { return stop.stop_requested(); };
    if (first > budget_ || !fine_.go_to(0, stopped) || !coarse_.go_to(0, stopped)) return first;
    const auto stretches = [&](const auto& motion) {
      return std::max(1.0, std::ceil(std::abs(time) / motion.span()));
    };
    return stretches(fine_) * work_ + stretches(coarse_) * coarse_work_;
  }

 private:
  /// Units of work of an operation: the instructions of an addition or a multiplication.
  static constexpr double operation_work = 8;
  static constexpr double epsilon = 1e-18, coarse_epsilon = 1e2 * epsilon;  ///< truncation errors
  inline static const int order = taylor_order(epsilon),
                          coarse_order = taylor_order(coarse_epsilon);

  static double series_work(const Matrix<long double>& start, int of_order) {
    return operation_work * Series::operations(start.rows(), start.cols(), of_order);
  }
  /// Returns the start of the second solution, which has a momentum larger by `order` roundings.
  /// The start and its first series are rounded in the same way in both solutions, so only a
  /// changed start shows what the motion makes of that rounding.
  static Matrix<long double> perturbed_by_rounding(Matrix<long double> x,
                                                   Eigen::Index momentum_rows) {
    x.bottomRows(momentum_rows) *= 1 + order * std::numeric_limits<long double>::epsilon();
    return x;
  }

  MotionState present(const TaylorMotion<Series>& motion) const {
    return stiefel::present(reported_, motion.state(), momentum_rows_);
  }

  /// Returns a bound on the rounding error, which the two solutions may have in common. A series is
  /// a sum of `order` rounded terms; each rounding is relative to the largest number on the way to
  /// the result.
  double rounding(const MotionState& state) const {
    constexpr double unit = std::numeric_limits<long double>::epsilon();
    const auto largest = [](const auto& A) {
      return A.size() > 0 ? static_cast<double>(A.cwiseAbs().maxCoeff()) : 0;
    };
    const double momentum = largest(state.momentum),
                 computed = largest(fine_.state().bottomRows(momentum_rows_));
    const double part = momentum > 0 ? computed / momentum : 1;
    return order * unit * std::max({1.0, largest(state.attitude), part});
  }

  ReportedForm<long double> reported_;
  double budget_;
  double work_, coarse_work_;
  Eigen::Index momentum_rows_;
  TaylorMotion<Series> fine_, coarse_;
  double error_ = 0, answers_ = 0;
};

/// Returns Taylor series in extended precision as reference; `make(order)` returns the series.
template <class Make>
std::unique_ptr<Reference> taylor_reference(const Make& make, const SeriesStart<long double>& start,
                                            const ReferenceNeed& need) {
  return std::make_unique<TaylorReference<decltype(make(1))>>(make, start, need.budget);
}

}  // namespace stiefel
