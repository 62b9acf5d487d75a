#include "stiefel/error_estimate.h"

#include <algorithm>
#include <cmath>

#include "engine/accuracy/measurement.h"
#include "engine/motion/step_weight.h"
#include "engine/numbers/to_text.h"
#include "stiefel/catalogue.h"
#include "stiefel/simulation.h"
#include "stiefel/stop.h"

namespace stiefel {
namespace {

/// A reference is accurate enough where its own error is at most this part of the measured one.
constexpr double accurate_enough = 0.25;
/// Smaller errors are not distinguished: they are of the size of the rounding of a state to
/// doubles.
constexpr double least_error = 2e-15;
/// Least ratio of the work in quadruple precision to that in extended precision.
constexpr double quadruple_over_extended = 12;

std::string work_text(double work) { return short_text(work) + " instructions"; }

struct Measured {
  MotionError error;
  std::optional<double> angle;
  double reference_error;

  /// Returns the smaller of the two errors, at least `least_error`.
  double least() const {
    return std::max(least_error, std::min(error.attitude.value_or(error.momentum), error.momentum));
  }
};

/// Returns the angle θ between two attitudes: ‖Q − Q̂‖_F = 2√2 sin(θ/2).
std::optional<double> angle_between(const MotionState& a, const MotionState& b) {
  if (a.attitude.rows() != 3 || a.attitude.cols() != 3) return std::nullopt;
  const auto chord = static_cast<double>((a.attitude - b.attitude).norm());
  return 2 * std::asin(std::min(1.0, chord / std::sqrt(8)));
}

/// Compares one simulation with references, the cheap one first.
class Comparison {
 public:
  Comparison(const Scene& scene, const Simulation& now, double budget, const std::stop_token& stop)
      : scene_(scene), now_(now), budget_(budget), stop_(stop) {
    out_.run_work = run_work(scene, now);
  }

  ErrorEstimate result() {
    if (catalogue().system(scene_.system())->discrete) {
      out_.missing = scene_.system() + " is a discrete system: its states have no method's error";
      return out_;
    }
    auto measured = measure(false);
    if (measured && measured->reference_error > accurate_enough * measured->least() &&
        (quadruple_over_extended + 1) * out_.work <= budget_) {
      if (const auto again = measure(true)) measured = again;
    }
    if (measured) {
      out_.missing.clear();
      report(*measured);
    }
    return out_;
  }

 private:
  std::optional<Measured> measure(bool quadruple) {
    auto measured = unless_stopped(stop_, [&] { return compared(quadruple); });
    if (measured) return *std::move(measured);
    return refuse("was cancelled after " + work_text(out_.work));
  }

  std::optional<Measured> compared(bool quadruple) {
    const double time = scene_.time(now_.step()), before = out_.work, left = budget_ - before;
    const auto reference = make_reference(scene_, {std::abs(time), left, quadruple});
    if (!reference) {
      out_.missing = "there is no reference for " + scene_.system();
      return std::nullopt;
    }
    if (reference->description() == out_.reference) return std::nullopt;
    if (const double predicted = reference->predicted_work(time, stop_); !(predicted <= left)) {
      out_.work = before + reference->work();
      return refuse("would take " + work_text(predicted) + " or more");
    }
    auto answer = reference->at(time, stop_);
    out_.work = before + reference->work();
    if (!answer) {
      const bool used_up = reference->work() >= left;
      return refuse(stop_.stop_requested() ? "was cancelled after " + work_text(out_.work)
                    : used_up              ? "takes more than " + work_text(left)
                              : "does not reach this step: its reference ended after " +
                                    work_text(out_.work));
    }
    const MotionState state = read_motion(scene_, now_);
    const MotionError error = error_of(state, answer->state);
    if (!std::isfinite(error.largest()) || !std::isfinite(answer->error))
      return refuse("overflows, after " + work_text(out_.work));
    out_.reference = reference->description();
    out_.reference_error = answer->error;
    return Measured{error, angle_between(state, answer->state), answer->error};
  }

  std::nullopt_t refuse(const std::string& what) {
    out_.missing = "the estimate " + what + "; the limit is " + short_text(budget_) +
                   ", and the run takes " + short_text(out_.run_work);
    return std::nullopt;
  }

  void report(const Measured& measured) {
    const double delta = measured.reference_error;
    if (delta > saturated_error) {
      out_.missing = "the error of the reference is " + short_text(delta) +
                     " at this step: the motion may be chaotic";
      return;
    }
    const auto told = [&](double error) {
      return error >= delta ? std::optional(error + delta) : std::nullopt;
    };
    if (measured.error.attitude) out_.attitude = told(*measured.error.attitude);
    out_.momentum = told(measured.error.momentum);
    // A difference of δ in every element is a difference of 3δ in the Frobenius norm.
    if (out_.attitude && measured.angle) out_.angle = *measured.angle + 3 * delta / std::sqrt(2);
    if (!out_.attitude && !out_.momentum)
      out_.missing = "the error is below that of the reference, " + short_text(delta);
  }

  const Scene& scene_;
  const Simulation& now_;
  double budget_;
  const std::stop_token& stop_;
  ErrorEstimate out_;
};

double largest(const ErrorEstimate& estimate) {
  return std::max(
      {estimate.attitude.value_or(0), estimate.momentum.value_or(0), estimate.reference_error});
}

/// Returns the estimate of the member with the largest error; if a member has no estimate, returns
/// that member's.
ErrorEstimate worst_member(const Scene& scene, const Simulation& now, double budget,
                           const std::stop_token& stop) {
  ErrorEstimate worst;
  double work = 0;
  const std::size_t count = scene.members().size();
  const auto states = now.members();  // brings the states of all members up to date
  for (std::size_t b = 0; b < count; ++b) {
    const double share = (budget - work) / static_cast<double>(count - b);
    auto one = estimate_error(scene.members()[b], *states[b], share, stop);
    work += one.work;
    one.member = static_cast<std::int64_t>(b);
    const bool missing = !one.missing.empty();
    if (b == 0 || missing || largest(one) > largest(worst)) worst = std::move(one);
    if (missing) break;
  }
  worst.work = work;
  worst.run_work = run_work(scene, now);
  return worst;
}

}  // namespace

double run_work(const Scene& scene, const Simulation& now) {
  if (!scene.members().empty()) {
    double all = 0;
    const auto states = now.members();
    for (std::size_t b = 0; b < scene.members().size(); ++b)
      all += run_work(scene.members()[b], *states[b]);
    return all;
  }
  const double steps = static_cast<double>(now.step()) * scene.substeps();
  const bool own_steps =
      scene.description().method && scene.description().method->tolerance.has_value();
  const double map_steps = now.direct() ? std::min(1.0, steps)
                           : own_steps  ? std::max(steps, static_cast<double>(now.map_steps()))
                                        : steps;
  return step_weight(scene) * map_steps;
}

ErrorEstimate estimate_error(const Scene& scene, const Simulation& now, double budget,
                             const std::stop_token& stop) {
  if (!scene.members().empty()) return worst_member(scene, now, budget, stop);
  return Comparison(scene, now, budget, stop).result();
}

}  // namespace stiefel
