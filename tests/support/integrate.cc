#include "tests/support/integrate.h"

#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>

namespace stiefel::testing {

std::vector<long double> solution(const Rates& field, std::vector<long double> x, long double t,
                                  long double tolerance) {
  using State = std::vector<long double>;
  boost::numeric::odeint::integrate_adaptive(
      boost::numeric::odeint::bulirsch_stoer<State, long double>(tolerance, tolerance),
      [&](const State& from, State& rates, long double) { field(from, rates); }, x, 0.0L, t,
      t / 100);
  return x;
}

}  // namespace stiefel::testing
