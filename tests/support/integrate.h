#pragma once

#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <vector>

#include "engine/methods/support/concepts.h"
#include "engine/frames/body/stiefel.h"

namespace stiefel::testing {

/// Returns the state of a system at time t, computed with Boost.odeint's Bulirsch–Stoer method in
/// the system's own scalar.
template <System S>
typename S::State integrate(S system, const typename S::State& start, typename S::Scalar t,
                            typename S::Scalar tolerance = 1e-17L) {
  using Scalar = typename S::Scalar;
  using Point = typename S::State;
  using Numbers = std::vector<Scalar>;
  Numbers x(start.data(), start.data() + start.size());
  Point at = start, rate = start;
  const auto field = [&](const Numbers& numbers, Numbers& rates, Scalar) {
    at = Eigen::Map<const Point>(numbers.data(), start.rows(), start.cols());
    system.field(at, rate);
    Eigen::Map<Point>(rates.data(), start.rows(), start.cols()) = rate;
  };
  using Stepper = boost::numeric::odeint::bulirsch_stoer<Numbers, Scalar>;
  boost::numeric::odeint::integrate_adaptive(Stepper(tolerance, tolerance), field, x, Scalar(0), t,
                                             t / 100);
  return Eigen::Map<const Point>(x.data(), start.rows(), start.cols());
}

// Compiled once, in integrate.cc.
extern template Matrix<long double> integrate(Stiefel<long double> system,
                                              const Matrix<long double>& start, long double t,
                                              long double tolerance);

}  // namespace stiefel::testing
