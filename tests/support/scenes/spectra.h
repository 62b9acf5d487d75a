#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "stiefel/lyapunov.h"
#include "tests/support/scenes/random_matrices.h"
#include "tests/support/scenes/resolved.h"

namespace stiefel::testing {

using Dense = Eigen::MatrixXd;

/// A geodesic of V(n, N) from a random frame, of unit speed.
inline SceneDescription geodesic(Eigen::Index n, const std::vector<double>& inertia, unsigned seed,
                                 double step, const std::string& method = "variational",
                                 int order = 4) {
  const auto N = static_cast<Eigen::Index>(inertia.size());
  const Eigen::Map<const Eigen::VectorXd> lambda(inertia.data(), N);
  RandomMatrices<double> random(seed);
  const Dense Q = random.frame(n, N);
  Dense V = random.matrix(n, N);
  const Dense R = V * Q.transpose();
  V -= (R + R.transpose()) * Q / 2;
  V /= std::sqrt((V.cwiseAbs2() * lambda).sum());
  SceneDescription out;
  out.system = "stiefel";
  out.method = MethodDescription{method, {}, {}, ""};
  if (order > 0) out.method->order = order;
  out.inertia = inertia;
  out.initial = {{"Q", Block(Q)}, {"S", Block((V * lambda.asDiagonal()).eval())}};
  out.step = step;
  return out;
}

/// A body of N dimensions with ‖M‖ about 1.
inline SceneDescription body(const std::vector<double>& inertia, unsigned seed, double step) {
  const auto N = static_cast<Eigen::Index>(inertia.size());
  RandomMatrices<double> random(seed);
  const Dense M = random.skew(N);
  SceneDescription out;
  out.system = "rigid_body";
  out.method = MethodDescription{"variational", {}, {}, ""};
  out.inertia = inertia;
  out.initial = {{"Q", Block(Dense(Dense::Identity(N, N)))}, {"M", Block((M / M.norm()).eval())}};
  out.step = step;
  return out;
}

inline std::unique_ptr<LyapunovExponents> begun(const Scene& scene, const LyapunovDescription& what,
                                                const Simulation& start) {
  auto made = LyapunovExponents::make(scene, what, start);
  if (!made)
    throw std::runtime_error(made.error().front().field + ": " + made.error().front().rule);
  return *std::move(made);
}
inline std::unique_ptr<LyapunovExponents> spectrum_of(const Scene& scene,
                                                      const LyapunovDescription& what) {
  const auto motion = make_simulation(scene);
  auto out = begun(scene, what, *motion);
  while (!out->done())
    if (!out->advance(*motion, 1000).reached()) break;
  return out;
}
inline std::string said(const std::unique_ptr<LyapunovExponents>& spectrum, unsigned seed = 0) {
  return "seed " + std::to_string(seed) + ": " + spectrum->reason();
}

}  // namespace stiefel::testing
