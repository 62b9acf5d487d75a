#pragma once

#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "tests/bench/measure.h"
#include "tests/bench/peers/contestant.h"
#include "tests/bench/peers/euler_equations.h"

namespace stiefel::bench {

/// Integrates with Boost.odeint's integrate_adaptive. The first step turns a body by 1/20 radian.
template <class Stepper>
Answer integrate(const Task& task, Stepper stepper) {
  Answer answer{};
  for (const auto& [I, omega] : task.bodies) {
    EulerEquations equations(I);
    EulerEquations::State x{1, 0, 0, 0, omega[0], omega[1], omega[2]};
    const double first = 0.05 / std::hypot(omega[0], omega[1], omega[2]);
    answer.seconds += processor_seconds([&] {
      boost::numeric::odeint::integrate_adaptive(stepper, std::ref(equations), x, 0.0, task.time,
                                                 first);
    });
    answer.work += equations.evaluations();
    if (!std::isfinite(x[0])) throw std::runtime_error("not finite");
    answer.ends.push_back({{x[0], x[1], x[2], x[3]}, {x[4], x[5], x[6]}});
  }
  return answer;
}

/// Returns Boost.odeint's contestants, with states of fixed size and equal absolute and relative
/// tolerances.
inline std::vector<Contestant> odeint_contestants() {
  using State = EulerEquations::State;
  return {{"odeint", "fehlberg78", "tolerance", "evaluations",
           [](const Task& task) {
             using Fehlberg78 = boost::numeric::odeint::runge_kutta_fehlberg78<State>;
             return integrate(task, boost::numeric::odeint::make_controlled<Fehlberg78>(
                                        task.setting, task.setting));
           }},
          {"odeint", "bulirsch_stoer", "tolerance", "evaluations", [](const Task& task) {
             using BulirschStoer = boost::numeric::odeint::bulirsch_stoer<State>;
             return integrate(task, BulirschStoer(task.setting, task.setting));
           }}};
}

}  // namespace stiefel::bench
