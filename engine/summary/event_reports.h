#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/summary/event_search.h"
#include "engine/summary/member.h"
#include "engine/summary/plan.h"

namespace stiefel {

/// Finds the events in the steps of a group's members, and reports them in their order.
class EventReports {
 public:
  /// An event after which a member ends.
  struct Terminal {
    std::size_t event;
    double fraction;  ///< of the member's last step
  };

  /// `start` is the simulation of a member. The plan must outlive this object.
  EventReports(const Plan& plan, const Simulation& start)
      : plan_(plan), functions_(plan.what.events, start) {}

  bool any() const { return !plan_.what.events.empty(); }
  /// Whether any event of the member has not reached its limit.
  bool waits(const Member& member) const;
  /// Sets the values of g at the first state, of step k.
  void begin(Member& member, std::int64_t k, const Simulation& now, const std::stop_token& stop) {
    if (any()) values(member, k, now, member.g, stop);
  }
  /// Reports the events in the last step of a member, up to the one that ends it.
  std::optional<Terminal> report(Member& member, const LastStep& step, const std::stop_token& stop);
  std::vector<Event>& reported() { return reported_; }

 private:
  /// Whether an event of the member has not reached its limit.
  bool waits(const Member& member, std::size_t event) const {
    const std::uint64_t limit = plan_.what.events[event].limit;
    return limit == 0 || member.events[event] < limit;
  }
  /// A zero of an event's function in the last step.
  struct Zero {
    std::size_t event;
    double fraction;
  };
  std::vector<Zero> zeros(Member& member, const LastStep& step, const std::stop_token& stop);
  /// Computes g, or of an extremum g', of all events at the state of `now`, of step k.
  void values(Member& member, std::int64_t k, const Simulation& now, std::vector<double>& g,
              const std::stop_token& stop);
  /// Returns the derivative of g with respect to the step at step k + fraction; nullopt where a
  /// step near it has no solution. `saved` is the state at step k.
  std::optional<double> slope(Member& member, std::size_t event, std::int64_t k, double fraction,
                              std::span<const double> saved, const std::stop_token& stop);

  const Plan& plan_;
  EventFunctions functions_;
  std::vector<double> g_;
  std::vector<Event> reported_;
};

}  // namespace stiefel
