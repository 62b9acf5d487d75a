#pragma once

#include "engine/problems/connect.h"
#include "engine/simulation/scene/scene.h"

namespace stiefel {

/// The geodesic between two frames as a scene that anybody can run.
struct JoiningScene {
  Scene scene;  ///< from Q_0: `rigid_body` where n = N, else `stiefel`; `variational`
  double energy;
  double residual;
  Shortest shortest;
  int distinct;
  std::vector<Eigen::MatrixXd> trajectory;  ///< Q at `samples` + 1 equal times; empty for 0
};

/// The problem's answer; for steps > 0 that of its discrete form, whose scene takes `steps` steps
/// of order 2 to Q_T. Else the scene's step is time / max(samples, 1), of order 8 with as many
/// substeps as make h‖Q̇‖ 0.02.
std::expected<JoiningScene, ConnectRefusal> joining_scene(const TwoPointProblem& problem, int steps,
                                                          int samples);

}  // namespace stiefel
