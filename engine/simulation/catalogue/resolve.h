#pragma once

#include <expected>

#include "stiefel/scene.h"

namespace stiefel {

/// Whether a method is still to be chosen for a tolerance before Scene::resolve takes it.
bool wants_choice(const SceneDescription& description);

/// The violations that Scene::resolve finds in such a description, except those of its method.
Violations check_before_choice(const SceneDescription& description, double largest_repair,
                               const Place& place);

/// The violations of an ensemble that still wants a choice, as `resolve_members` finds them.
Violations check_members_before_choice(const SceneDescription& ensemble, double largest_repair,
                                       const Place& place);

/// "the method must be chosen for the tolerance first", with reason METHOD_NOT_CHOSEN.
Violation method_not_chosen(const Place& place);

/// Checks the members of an ensemble as scenes of their own (scene/members.h), one after another,
/// and gives the first. What the description leaves open (method, order, ...) is filled in, in
/// `ensemble` too, the same for all members. Only ε each chooses from its own ‖M‖: `ensemble` has
/// it where they agree, else none. The violations are of the first members that have any, at most
/// 16.
std::expected<Scene, Violations> resolve_members(SceneDescription& ensemble, double largest_repair,
                                                 const Place& place);

}  // namespace stiefel
