#pragma once

#include <expected>

#include "stiefel/scene.h"

namespace stiefel {

/// Whether a method must still be chosen for a tolerance before Scene::resolve accepts the
/// description.
bool wants_choice(const SceneDescription& description);

/// Returns the violations that Scene::resolve finds in such a description, except those of its
/// method.
Violations check_before_choice(const SceneDescription& description, double largest_repair,
                               const Place& place);

/// Returns the violations of an ensemble for which a method must still be chosen, as
/// `resolve_members` finds them.
Violations check_members_before_choice(const SceneDescription& ensemble, double largest_repair,
                                       const Place& place);

/// Returns the violation "the method must be chosen for the tolerance first", with reason
/// METHOD_NOT_CHOSEN.
Violation method_not_chosen(const Place& place);

/// Checks the members of an ensemble as scenes of their own (scene/members.h), one after another,
/// and returns the first. Fills in what the description leaves open (method, order, ...), also in
/// `ensemble`, with the same values for all members. Only ε is chosen by each member, from its own
/// ‖M‖: `ensemble` gets it where all members agree, else none. The violations are those of the
/// first members that have any, at most 16.
std::expected<Scene, Violations> resolve_members(SceneDescription& ensemble, double largest_repair,
                                                 const Place& place);

}  // namespace stiefel
