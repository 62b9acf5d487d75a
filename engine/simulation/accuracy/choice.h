#pragma once

#include <expected>
#include <string>

#include "stiefel/scene.h"

namespace stiefel {

/// What a scene with a tolerance instead of a method gets.
struct Choice {
  MethodDescription method;
  /// What was chosen, and why: error, up to when, against which reference, at which work.
  std::string reason;
};

/// The cheapest method, order, arithmetic and substeps whose error, the largest of attitude and
/// momentum at eight times up to `horizon` and there, stays within `tolerance`, by runs of this
/// scene worth about a second: errors against a reference, work counted, never the clock. Each
/// number of substeps follows from the last by the declared order and is then run. Where whole runs
/// would cost too much, shorter ones are extrapolated by the declared growth, doubled; runs in
/// single precision are not, and are then out of the question.
///
/// Expects a sound description with tolerance, horizon and step. When nothing meets the tolerance
/// the refusal has reason TOLERANCE_NOT_MET, with the best that was found.
std::expected<Choice, Violations> choose_method(const SceneDescription& description,
                                                const Place& place = {});

}  // namespace stiefel
