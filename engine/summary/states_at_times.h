#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/summary/member.h"
#include "engine/summary/plan.h"
#include "stiefel/summary.h"

namespace stiefel {

/// Returns the values of the fields that are written at times and events (Plan::fields), one field
/// after another, at the state of `now`, the simulation of one member.
std::vector<double> written_fields(const Plan& plan, const Simulation& now);

/// Writes the states of a group's members at the times of a description.
class StatesAtTimes {
 public:
  /// The plan must outlive this object. `direct` is Simulation::direct of the members.
  StatesAtTimes(const Plan& plan, bool direct) : plan_(plan), direct_(direct) {}

  /// Sets where states are written; the first of `states` is that of time index `first_time`.
  void write_to(std::size_t first_time, std::span<StateAtTime> states) {
    first_time_ = first_time;
    states_ = states;
  }
  /// Returns the first time beyond the current step, or null.
  const Plan::Time* next() const {
    return next_ < plan_.times.size() ? &plan_.times[next_] : nullptr;
  }
  /// Passes over the times up to step `to`.
  void pass(std::int64_t to) {
    while (next_ < plan_.times.size() && plan_.times[next_].arrival <= to) ++next_;
  }
  /// Writes the states of a member at the times up to the fraction `up_to` of its last step.
  void write(Member& member, const LastStep& step, double up_to, const std::stop_token& stop);
  /// Returns the number of times up to the last one that any member reached.
  std::size_t reached() const { return reached_; }

 private:
  const Plan& plan_;
  bool direct_;
  std::size_t next_ = 0, reached_ = 0, first_time_ = 0;
  std::span<StateAtTime> states_;
};

}  // namespace stiefel
