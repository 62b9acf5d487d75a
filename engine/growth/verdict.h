#pragma once

#include <string>

#include "engine/growth/growth.h"
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

/// Returns what remains of the judgement `found`, "chaotic", with the growth of a confirmation,
/// which is incomplete if not `reached`: it must exceed a regular motion's as far. `how`: its map,
/// empty if it is that of a discrete system. `attempt`: 0 or 1.
Judgement confirmed(const Judgement& found, const Growth& growth, const Growth& beside, double rate,
                    bool reached, const std::string& how, std::int64_t attempt);

}  // namespace stiefel
