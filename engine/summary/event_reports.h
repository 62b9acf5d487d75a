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
  /// Sets the values of g at the first state.
  void begin(Member& member, const Simulation& now) {
    if (any()) functions_.values(now, member.g);
  }
  /// Reports the events in the last step of a member, number `index` of the ensemble, up to the one
  /// that ends it.
  std::optional<Terminal> report(Member& member, std::size_t index, const LastStep& step,
                                 const std::stop_token& stop);
  std::vector<Event>& reported() { return reported_; }

 private:
  /// A zero of an event's function in the last step.
  struct Zero {
    std::size_t event;
    double fraction;
  };
  std::vector<Zero> zeros(Member& member, const LastStep& step, const std::stop_token& stop);

  const Plan& plan_;
  EventFunctions functions_;
  std::vector<double> g_;
  std::vector<Event> reported_;
};

}  // namespace stiefel
