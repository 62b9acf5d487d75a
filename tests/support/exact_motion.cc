#include "tests/support/exact_motion.h"

#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <vector>

namespace stiefel::testing {

Motion exact_motion(const Eigen::VectorXd& lambda, const Eigen::MatrixXd& Q,
                    const Eigen::MatrixXd& M, double t, long double tolerance) {
  using Wide = long double;
  using Matrix = Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic>;
  using State = std::vector<Wide>;
  const Eigen::Index N = lambda.size(), size = N * N;

  State x(static_cast<std::size_t>(2 * size));
  Eigen::Map<Matrix>(x.data(), N, N) = Q.cast<Wide>();
  Eigen::Map<Matrix>(x.data() + size, N, N) = M.cast<Wide>();
  const auto field = [&](const State& state, State& rate, Wide) {
    const Eigen::Map<const Matrix> frame(state.data(), N, N), momentum(state.data() + size, N, N);
    Matrix Omega = momentum;
    for (Eigen::Index i = 0; i < N; ++i)
      for (Eigen::Index j = 0; j < N; ++j)
        if (i != j) Omega(i, j) /= Wide(lambda(i)) + Wide(lambda(j));
    Eigen::Map<Matrix>(rate.data(), N, N) = frame * Omega;
    Eigen::Map<Matrix>(rate.data() + size, N, N) = momentum * Omega - Omega * momentum;
  };
  using Stepper = boost::numeric::odeint::bulirsch_stoer<State, Wide>;
  boost::numeric::odeint::integrate_adaptive(Stepper(tolerance, tolerance), field, x, Wide(0),
                                             Wide(t), Wide(t) / 100);
  return {Eigen::Map<Matrix>(x.data(), N, N).cast<double>(),
          Eigen::Map<Matrix>(x.data() + size, N, N).cast<double>()};
}

}  // namespace stiefel::testing
