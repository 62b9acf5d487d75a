#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "engine/summary/member.h"
#include "engine/summary/plan.h"

namespace stiefel {

/// Finds the events in the steps of a group's members, and reports them in their order.
class Events {
 public:
  /// An event after which a member ends.
  struct Terminal {
    std::size_t event;
    double fraction;  ///< of the member's last step
  };

  /// `start` is the simulation of a member. The plan must outlive this object.
  Events(const Plan& plan, const Simulation& start);

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
  struct Term {
    std::size_t field;  ///< index in fields_
    const std::vector<double>* coefficients;
  };
  /// The function g of an event. Where it has Euler angles, it jumps by its period where such an
  /// angle jumps by 2π: it is reduced to half its period, and a change by half of it or more from
  /// one state to the next is such a jump.
  struct Function {
    std::vector<Term> terms;
    long double period = 0;
  };
  struct Read {
    std::size_t index;  ///< index among the simulation's fields
    std::vector<double> numbers;
  };
  /// A zero of an event's function in the last step.
  struct Zero {
    std::size_t event;
    double fraction;
  };

  void add(const Simulation& start, const std::string& field,
           const std::vector<double>& coefficients, Function& to);
  /// Returns g of an event at the fields that were read, a sum in extended precision in the order
  /// of the terms and of their fields' numbers.
  double sum(std::size_t event) const;
  /// Returns g of one event at a state.
  double value(const Simulation& now, std::size_t event);
  /// Computes g, or of an extremum g', of all events at the state of `now`, of step k.
  void values(Member& member, std::int64_t k, const Simulation& now, std::vector<double>& g,
              const std::stop_token& stop);
  /// Returns the derivative of g with respect to the step at step k + fraction; nullopt where a
  /// step near it has no solution. `saved` is the state at step k.
  std::optional<double> slope(Member& member, std::size_t event, std::int64_t k, double fraction,
                              std::span<const double> saved, const std::stop_token& stop);
  /// Whether an event of the member has not reached its limit.
  bool waits(const Member& member, std::size_t event) const {
    const std::uint64_t limit = plan_.what.events[event].limit;
    return limit == 0 || member.events[event] < limit;
  }
  std::vector<Zero> zeros(Member& member, const LastStep& step, const std::stop_token& stop);

  const Plan& plan_;
  std::vector<Read> fields_;
  std::vector<Function> functions_;
  std::vector<double> g_;
  std::vector<Event> reported_;
};

}  // namespace stiefel
