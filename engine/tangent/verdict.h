#pragma once

#include <optional>
#include <string>

#include "engine/tangent/growth.h"
#include "stiefel/lyapunov.h"

namespace stiefel {

/// What the growth of tangent vectors says of a motion, and why.
struct Judgement {
  MotionKind kind = MotionKind::undecided;
  std::string reason = "The motion has not reached the last step.";
};

/// Judges by four means over the last octaves of time, whatever the unit: how the largest growth
/// S_1 rises (by a constant a doubling: regular; over three octaves at least like √t, and to far
/// beyond c ln t: chaotic), how GALI falls (by a power, or exponentially), and whether S_1 fell so
/// far that rounding decides. `rate`: that of the motion at its start, 1/time.
Judgement judge_growth(const Growth& growth, double rate);

/// The time for which a motion beside one that looks chaotic runs, in units of 1/lambda.
constexpr double beside_growth = 100;
/// It ends early where it has grown by e to this power: no passage of an unstable motion gives so
/// much.
constexpr double beside_enough = 50;
/// The distance at which it starts, relative to the norms of the blocks.
constexpr double beside_distance = 1e-4;

/// Returns a scene that starts `direction` times `beside_distance` beside the state of `now`, with
/// `beside_substeps` times as many substeps; nullopt where none can be made. `direction` is a
/// tangent vector.
std::optional<Scene> scene_beside(const Scene& scene, const Simulation& now,
                                  const Eigen::MatrixXd& direction);
/// Returns what remains of the judgement `found`, "chaotic", with the growth of a motion beside,
/// which may be missing or, if not `reached`, incomplete.
Judgement confirm(const Judgement& found, const Growth& growth, const Growth* beside, bool reached);

}  // namespace stiefel
