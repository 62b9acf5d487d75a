#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/summary/partial_step.h"
#include "stiefel/summary.h"

namespace stiefel {

/// The functions g of a description's events, evaluated at states of one scene.
class EventFunctions {
 public:
  /// The fields must be among those of `start`. Refers to `events`.
  EventFunctions(const std::vector<EventDescription>& events, const Simulation& start);

  std::size_t size() const { return functions_.size(); }
  /// `values` computes g of all events at a state, with sums in extended precision in the order of
  /// the terms and of their fields' numbers; `value` computes g of one event. A g with Euler angles
  /// is reduced to half its period.
  void values(const Simulation& now, std::vector<double>& g);
  double value(const Simulation& now, std::size_t event);
  /// Returns by how much g jumps where an Euler angle jumps by 2π; 0 where it has none. A change by
  /// half of it or more from one state to the next is such a jump.
  double period(std::size_t event) const { return static_cast<double>(functions_[event].period); }

 private:
  struct Term {
    std::size_t field;  ///< index in fields_
    const std::vector<double>* coefficients;
  };
  struct Function {
    std::vector<Term> terms;
    double level;
    long double period = 0;
  };
  struct Read {
    std::size_t index;  ///< index among the simulation's fields
    std::vector<double> numbers;
  };
  void add(const Simulation& start, const std::string& field,
           const std::vector<double>& coefficients, Function& to);
  double sum(const Function& function) const;

  std::vector<Read> fields_;
  std::vector<Function> functions_;
};

/// Whether a zero of g lies after a state with g = `before`, up to the next state, where g =
/// `after`.
bool crosses(double before, double after, Direction direction);

/// Returns the fraction of the step, in (0, 1], at which g is 0, to `width`, by Alefeld, Potra and
/// Shi's algorithm 748. `g(fraction)` returns nullopt where the shorter step has no solution; the
/// result is then 1.
double zero_fraction(const std::function<std::optional<double>(double)>& g, double before,
                     double after, double width = 0x1p-52);

}  // namespace stiefel
