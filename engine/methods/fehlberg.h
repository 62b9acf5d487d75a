#pragma once

#include <array>
#include <functional>
#include <vector>

namespace stiefel {

/// The pair of Runge–Kutta methods of orders 7 and 8 (Fehlberg 1968) for dx/dt = field(x), on the
/// numbers of a state. Compiled once, in fehlberg.cc. Allocates only
/// where the number of numbers changes.
template <class Scalar>
class Fehlberg {
 public:
  using Numbers = std::vector<Scalar>;
  using Field = std::function<void(const Numbers& x, Numbers& dx)>;
  static constexpr int stages = 13;

  /// Sets `next` to x after a time h, to the eighth order, and `error` to an estimate of the error
  /// of the seventh. `slope` is field(x).
  void step(const Field& field, const Numbers& x, const Numbers& slope, Scalar h, Numbers& next,
            Numbers& error);

 private:
  std::array<Numbers, stages> slopes_;  ///< of the stages after the first
};

}  // namespace stiefel
