#include "stiefel/connect.h"

#include <algorithm>
#include <cmath>

#include "engine/frame/geodesics/isotropic_geodesic.h"
#include "engine/frame/stiefel.h"
#include "engine/methods/method.h"
#include "engine/motion/representation.h"
#include "engine/numbers/to_text.h"
#include "stiefel/simulation.h"

namespace stiefel {
namespace {

constexpr double turn_per_step = 0.02;

/// Returns the scene of an answer. Refuses a time so short that step or velocity is not finite.
template <class Answer>
std::expected<Scene, ConnectRefusal> scene_of(const TwoPointProblem& problem, const Answer& answer,
                                              const Eigen::MatrixXd& Q_0, MethodDescription method,
                                              double step) {
  const bool body = answer.M.size() > 0;
  SceneDescription d;
  d.system = body ? representations::body_system : Stiefel<double>::name;
  d.method = std::move(method);
  if (problem.beta)
    d.inertia.assign(static_cast<std::size_t>(Q_0.cols()), body ? *problem.beta : 1.0);
  else
    d.inertia = {problem.inertia.begin(), problem.inertia.end()};
  d.initial["Q"] = Q_0;
  d.initial[body ? "M" : "S"] = body ? answer.M : answer.S;
  d.step = step;
  auto made = Scene::resolve(std::move(d));
  if (made) return *std::move(made);
  return std::unexpected(
      refusal::Invalid{"time", to_text(problem.time), "makes numbers that no scene can hold"});
}

/// Returns Q at step 0 and at `samples` steps after it, or at fewer steps on a stop request.
std::vector<Eigen::MatrixXd> followed(const Scene& scene, int samples,
                                      const std::stop_token& stop) {
  std::vector<Eigen::MatrixXd> frames;
  if (samples == 0) return frames;
  const auto simulation = make_simulation(scene);
  frames.push_back(simulation->get("Q"));
  for (int k = 0; k < samples && simulation->advance(1, stop).reached(); ++k)
    frames.push_back(simulation->get("Q"));
  return frames;
}

std::expected<JoiningScene, ConnectRefusal> discrete(const TwoPointProblem& problem, int steps,
                                                     bool with_scene) {
  const auto answer = connect(problem, steps);
  if (!answer) return std::unexpected(answer.error());
  auto scene = scene_of(problem, *answer, answer->Q[0], {method_name::variational, 2, 1, ""},
                        problem.time / steps);
  if (!scene) return std::unexpected(std::move(scene.error()));
  JoiningScene out{
      {}, {}, answer->energy, answer->residual, Shortest::unknown, answer->distinct, answer->Q};
  if (with_scene) out.scene = *std::move(scene);
  return out;
}

std::expected<JoiningScene, ConnectRefusal> continuous(const TwoPointProblem& problem, int samples,
                                                       bool with_scene) {
  auto answer = connect(problem);
  if (!answer) return std::unexpected(answer.error());
  JoiningScene out{{}, {}, answer->energy, answer->residual, answer->shortest, answer->distinct,
                   {}};
  const bool has_scene = answer->S.size() > 0;
  if (has_scene && (with_scene || samples > 0)) {
    const double step = problem.time / std::max(samples, 1);
    const double wanted = std::ceil(answer->Qdot.norm() * step / turn_per_step);
    const int substeps = static_cast<int>(std::clamp(wanted, 1.0, 1e6));
    auto scene =
        scene_of(problem, *answer, answer->Q, {method_name::variational, 8, substeps, ""}, step);
    if (!scene) return std::unexpected(scene.error());
    out.trajectory = followed(*scene, samples, problem.stop);
    if (with_scene) out.scene = *std::move(scene);
  } else if (samples > 0) {
    Eigen::MatrixXd start(2 * answer->Q.rows(), answer->Q.cols());
    start << answer->Q, answer->Qdot;
    IsotropicGeodesic<double> motion(Eigen::VectorXd::Ones(start.cols()), start, *problem.beta);
    for (int k = 0; k <= samples; ++k)
      out.trajectory.push_back(motion.at(k * problem.time / samples).topRows(answer->Q.rows()));
  }
  out.Qdot = std::move(answer->Qdot);
  if (problem.stop.stop_requested()) return std::unexpected(refusal::Cancelled{});
  return out;
}

}  // namespace

std::expected<JoiningScene, ConnectRefusal> joining_scene(const TwoPointProblem& problem, int steps,
                                                          int samples, bool with_scene) {
  return steps > 0 ? discrete(problem, steps, with_scene)
                   : continuous(problem, samples, with_scene);
}

}  // namespace stiefel
