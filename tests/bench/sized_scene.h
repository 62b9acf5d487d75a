#pragma once

#include <string>

#include "stiefel/catalogue.h"
#include "tests/support/scenes/any_scene.h"
#include "tests/support/scenes/random_frame.h"

namespace stiefel::bench {

struct Size {
  int n, N;
};

/// Returns whether the states of the system are frames of V(n, N) with any n, or points of V(1, N).
inline bool on_frames(const std::string& system) {
  return system == "ellipsoid" || system.starts_with("stiefel");
}

/// Returns a scene with a seeded state on V(n, N) and `step` = h‖Q̇‖. `round`: whether Λ = I, for
/// which there are closed forms.
inline SceneDescription frames(const std::string& system, Size size, bool round, unsigned seed,
                               double step) {
  const testing::RandomFrame<double> frame(size.n, size.N, seed, round ? 1 : 4);
  const Eigen::MatrixXd Qdot = frame.S * frame.lambda.cwiseInverse().asDiagonal();
  SceneDescription d;
  d.system = system;
  d.inertia = {frame.lambda.begin(), frame.lambda.end()};
  const bool vector = system == "ellipsoid";
  d.initial[vector ? "q" : "Q"] = frame.Q;
  if (vector) d.initial["qdot"] = Qdot;
  if (system == "stiefel") d.initial["S"] = frame.S;
  if (system == "stiefel_costate") d.initial["P"] = frame.S;
  if (system == "stiefel_momentum")
    d.initial["M"] = Eigen::MatrixXd(frame.Q.transpose() * frame.S - frame.S.transpose() * frame.Q);
  d.step = step;
  return d;
}

/// Returns a seeded scene of a given size without a method. Systems of a single size ignore the
/// size.
inline SceneDescription sized_scene(const std::string& system, const std::string& method, Size size,
                                    unsigned seed, double step) {
  const MethodInfo* info = catalogue().method(method);
  const bool closed_form = info != nullptr && info->orders.empty();
  if (on_frames(system)) return frames(system, size, closed_form, seed, step);
  return testing::any_scene(system, closed_form ? method : "", seed, step, size.N);
}

}  // namespace stiefel::bench
