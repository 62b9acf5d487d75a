#pragma once

#include <expected>
#include <vector>

#include "stiefel/scene.h"

namespace stiefel {

/// The members of an ensemble as scenes of their own, from a description with `members` = B: what
/// has B times the numbers of one scene is theirs in turn, blocks by their rows, and everything
/// else is common to all. What it leaves open (method, order, ...) is filled in, in `ensemble` too,
/// the same for all members. Only ε each chooses from its own ‖M‖: `ensemble` has it where they
/// agree, else none. The violations are of the first members that have any, at most 16.
std::expected<std::vector<Scene>, Violations> resolve_members(SceneDescription& ensemble,
                                                              double largest_repair,
                                                              const Place& place);

}  // namespace stiefel
