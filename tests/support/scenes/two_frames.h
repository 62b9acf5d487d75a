#pragma once

#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <random>

#include "engine/dense/decompositions.h"
#include "engine/frame/geodesics/path.h"
#include "stiefel/connect.h"

namespace stiefel::testing {

/// Returns the problem to join two seeded random frames of equal determinant, with Λ between 1 and
/// `spread`.
inline TwoPointProblem random_frames(int n, int N, double spread, std::uint64_t seed) {
  std::mt19937_64 generator(1000 * seed + static_cast<std::uint64_t>(n));
  const auto uniform = [&] { return std::generate_canonical<double, 53>(generator); };
  const auto frame = [&] {
    Eigen::MatrixXd A(n, N);
    for (double& x : A.reshaped()) x = 2 * uniform() - 1;
    A = polar(A);
    if (n == N && determinant(A) < 0) A.row(0) = -A.row(0);
    return A;
  };
  TwoPointProblem problem;
  problem.inertia.resize(N);
  for (double& l : problem.inertia) l = std::pow(spread, uniform());
  problem.inertia(0) = 1;
  problem.inertia(N - 1) = spread;
  problem.Q_0 = frame();
  problem.Q_T = frame();
  problem.seed = seed;
  return problem;
}

}  // namespace stiefel::testing
