#pragma once

#include "stiefel/v1/scene.pb.h"

namespace stiefel::client {

/// A tumbling body in three dimensions.
inline v1::Scene tumbling() {
  v1::Scene scene;
  scene.set_system("rigid_body");
  scene.mutable_method()->set_name("variational");
  for (const double moment : {3.0, 2.0, 1.0}) scene.mutable_body()->add_moments(moment);
  for (const double omega : {0.1, 2.0, 0.1}) scene.mutable_body()->add_angular_velocity(omega);
  scene.set_step(0.01);
  return scene;
}

/// At rest in N dimensions.
inline v1::Scene resting(int N) {
  v1::Scene scene;
  scene.set_system("rigid_body");
  scene.mutable_method()->set_name("rk4");
  v1::Matrix Q;
  Q.set_rows(N);
  Q.set_cols(N);
  for (int i = 0; i < N * N; ++i) Q.add_values(i % (N + 1) == 0 ? 1 : 0);
  v1::Matrix M = Q;
  for (double& value : *M.mutable_values()) value = 0;
  for (int i = 0; i < N; ++i) scene.add_inertia(1);
  (*scene.mutable_initial())["Q"] = Q;
  (*scene.mutable_initial())["M"] = M;
  scene.set_step(0.01);
  return scene;
}

}  // namespace stiefel::client
