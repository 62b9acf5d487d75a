#pragma once

#include <cstdint>
#include <stop_token>

#include "engine/methods/fehlberg.h"
#include "engine/numbers/scalar.h"
#include "stiefel/run_status.h"

namespace stiefel {

/// The substeps of one step of Adaptive, on the numbers of a state in their order in memory. They
/// are compiled once, for all systems.
class AdaptiveSubsteps {
 public:
  using Numbers = Fehlberg<double>::Numbers;
  /// Most attempts in one step.
  static constexpr int most_substeps = 10000;

  virtual ~AdaptiveSubsteps() = default;
  /// Returns the number of substeps tried so far.
  std::int64_t attempts() const { return attempts_; }

 protected:
  AdaptiveSubsteps(double h, double tolerance) : h_(h), tolerance_(tolerance) {}
  AdaptiveSubsteps(AdaptiveSubsteps&&) noexcept = default;
  AdaptiveSubsteps& operator=(AdaptiveSubsteps&&) noexcept = default;

  /// Prepares for states of this shape; a second call does nothing.
  void prepare(Eigen::Index rows, Eigen::Index cols);

  /// Sets x_ to x(t + h).
  Outcome integrate(const std::stop_token& stop);

  /// Computes the vector field.
  virtual void evaluate(const Numbers& x, Numbers& dx) = 0;

  Numbers x_;

 private:
  double relative_error() const;
  double size() const;

  double h_, tolerance_;
  std::int64_t attempts_ = 0;
  Eigen::Index rows_ = 0, cols_ = 0;
  Fehlberg<double> fehlberg_;
  Numbers next_, slope_now_, error_;
};

}  // namespace stiefel
