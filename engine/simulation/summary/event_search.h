#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/simulation/summary/partial_step.h"
#include "stiefel/summary.h"

namespace stiefel {

/// The functions g of a description's events, at states of one scene.
class EventFunctions {
 public:
  /// The fields must be among those of `start`.
  EventFunctions(const std::vector<EventDescription>& events, const Simulation& start);

  std::size_t size() const { return terms_.size(); }
  /// g of all events at a state; sums in extended precision, in the order of the field's numbers.
  void values(const Simulation& now, std::vector<double>& g);
  double value(const Simulation& now, std::size_t event);

 private:
  struct Terms {
    std::size_t field;  ///< in fields_
    const EventDescription* event;
  };
  struct Read {
    std::size_t index;  ///< of the simulation's fields
    std::vector<double> numbers;
  };
  double sum(const Terms& terms) const;

  std::vector<Read> fields_;
  std::vector<Terms> terms_;
};

/// Whether a zero lies after a state with g = `before`, up to the next state, where g = `after`.
bool crosses(double before, double after, Direction direction);

/// The fraction of the step, in (0, 1], at which g is 0, to rounding: by Alefeld, Potra and Shi's
/// algorithm 748 on the fraction. `g(fraction)` is nothing where the shorter step has no solution;
/// the zero is then given as the next state.
double zero_fraction(const std::function<std::optional<double>(double)>& g, double before,
                     double after);

}  // namespace stiefel
