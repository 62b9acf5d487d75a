#pragma once

#include <functional>
#include <vector>

#include "engine/methods/concepts.h"
#include "engine/numbers/scalar.h"

namespace stiefel::testing {

/// Sets the rates of a state.
using Rates = std::function<void(const std::vector<long double>& x, std::vector<long double>& dx)>;

/// Returns the solution of dx/dt = field(x) at time t from x, computed in extended precision by
/// Boost.odeint's Bulirsch–Stoer method.
std::vector<long double> solution(const Rates& field, std::vector<long double> x, long double t,
                                  long double tolerance = 1e-17L);

/// Returns the state of a system at time t. Uses the engine's vector field, but none of its
/// methods.
template <System S>
Matrix<long double> integrate(S system, const Matrix<long double>& start, long double t,
                              long double tolerance = 1e-17L) {
  Matrix<long double> at = start, rate = start;
  const auto field = [&](const std::vector<long double>& x, std::vector<long double>& dx) {
    at.reshaped() = Vector<long double>::Map(x.data(), at.size());
    system.field(at, rate);
    Vector<long double>::Map(dx.data(), rate.size()) = rate.reshaped();
  };
  const auto x = solution(field, {start.data(), start.data() + start.size()}, t, tolerance);
  at.reshaped() = Vector<long double>::Map(x.data(), at.size());
  return at;
}

/// Returns the state at time t, with the state at time 0 and the result in double precision.
template <class S>
Eigen::MatrixXd flow(S system, const Eigen::MatrixXd& x, double t) {
  return integrate(std::move(system), x.cast<long double>(), t).template cast<double>();
}

}  // namespace stiefel::testing
