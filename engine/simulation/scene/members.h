#pragma once

#include "stiefel/scene.h"

namespace stiefel {

// An ensemble is described with `members` = B: what has B times the numbers of one scene is theirs
// in turn, blocks by their rows, and everything else is common to all.

/// The violations of a description of an ensemble.
Violations check_members(const SceneDescription& all, const Place& place);

/// Member b, 0 <= b < B, as a description of its own.
SceneDescription member_of(const SceneDescription& all, int b);

}  // namespace stiefel
