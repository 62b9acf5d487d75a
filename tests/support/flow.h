#pragma once

#include <Eigen/Core>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <vector>

namespace stiefel::testing {

/// Returns the solution of any System over long double at time t from x, computed with
/// Boost.odeint's Bulirsch–Stoer method and tolerance 1e-17. It uses the engine's vector field, but
/// none of its methods.
template <class S>
Eigen::MatrixXd flow(S system, const Eigen::MatrixXd& x, double t) {
  using Wide = long double;
  using Matrix = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;
  using State = std::vector<Wide>;
  static_assert(std::is_same_v<typename S::Scalar, Wide>);
  const Eigen::Index rows = x.rows(), cols = x.cols();
  State state(static_cast<std::size_t>(x.size()));
  Eigen::Map<Matrix>(state.data(), rows, cols) = x.cast<Wide>();
  Matrix at(rows, cols), rate(rows, cols);
  const auto field = [&](const State& from, State& to, Wide) {
    at = Eigen::Map<const Matrix>(from.data(), rows, cols);
    system.field(at, rate);
    Eigen::Map<Matrix>(to.data(), rows, cols) = rate;
  };
  using Stepper = boost::numeric::odeint::bulirsch_stoer<State, Wide>;
  boost::numeric::odeint::integrate_adaptive(Stepper(1e-17L, 1e-17L), field, state, Wide(0),
                                             Wide(t), Wide(t) / 100);
  return Eigen::Map<Matrix>(state.data(), rows, cols).cast<double>();
}

}  // namespace stiefel::testing
