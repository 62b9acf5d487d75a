#pragma once

#include <expected>

#include "stiefel/catalogue.h"
#include "stiefel/scene.h"

namespace stiefel {

class SceneDraft;
struct Body3;
struct MethodEntry;

/// Checks a draft of a single motion, also by its system, and its method if there is one.
void check_scene(SceneDraft& draft);

/// Checks the method of a draft, which must have one, against those of a continuous system, and
/// fills in what it leaves open: order, substeps, tolerance, arithmetic, scalar.
void check_method(SceneDraft& draft, const SystemInfo& system);

/// Checks that the method of a draft, if it has one, accepts the scene: Λ, and what
/// SystemEntry::refusal says. Call it once the system has checked its own fields.
void check_method_accepts_scene(SceneDraft& draft, const SystemInfo& system);

/// Whether a method, null for a discrete system, accepts a body in three dimensions given by
/// `body`.
bool accepts_body(const MethodEntry* method, const Body3& body, double step);

/// Whether the description is of a continuous system and has no method, so that a method must be
/// chosen for its tolerance or recommended before Scene::resolve accepts it.
bool lacks_method(const SceneDescription& description);
/// Whether the method must be chosen for a tolerance.
bool wants_choice(const SceneDescription& description);

/// Returns the violations that Scene::resolve finds in such a description, except that its method
/// is missing.
Violations check_before_choice(const SceneDescription& description, double largest_repair,
                               const Place& place);

/// Returns the violations of an ensemble that lacks a method, as `resolve_members` finds them.
Violations check_members_before_choice(const SceneDescription& ensemble, double largest_repair,
                                       const Place& place);

/// Returns the violation of a description that lacks a method, with the reason METHOD_NOT_CHOSEN.
Violation method_not_chosen(const SceneDescription& description, const Place& place);

/// Returns the first recommended method that takes all members of an ensemble, which has neither
/// method nor tolerance, with enough substeps for the fastest member; or the violations of the
/// members.
std::expected<MethodDescription, Violations> recommended_for_members(
    const SceneDescription& ensemble, double largest_repair, const Place& place);

/// Checks the members of an ensemble as scenes of their own (scene/members.h), one after another,
/// and returns the first. Fills in what the description leaves open (order, ...), also in
/// `ensemble`, with the same values for all members. Only ε is chosen by each member, from its own
/// ‖M‖: `ensemble` gets it where all members agree, else none. The violations are those of the
/// first members that have any, at most 16.
std::expected<Scene, Violations> resolve_members(SceneDescription& ensemble, double largest_repair,
                                                 const Place& place);

}  // namespace stiefel
