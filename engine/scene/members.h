#pragma once

#include "stiefel/scene.h"

namespace stiefel {

// The description of an ensemble has `members` = B. A field that has B times the numbers of one
// scene holds the members' numbers in turn, blocks their rows; every other field is common to all
// members.

/// Returns the violations of the description of an ensemble.
Violations check_members(const SceneDescription& all);

/// Returns the description of member b, 0 <= b < B.
SceneDescription member_of(const SceneDescription& all, int b);

}  // namespace stiefel
