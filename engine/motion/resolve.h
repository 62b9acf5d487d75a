#pragma once

#include "stiefel/catalogue.h"
#include "stiefel/scene.h"

namespace stiefel {

class SceneDraft;
struct Body3;
struct MethodEntry;

/// Checks the method of a draft, which must have one, against those of a continuous system, and
/// fills in what it leaves open: order, substeps, tolerance, arithmetic, scalar.
void check_method(SceneDraft& draft, const SystemInfo& system);

/// Checks that the method of a draft, if it has one, accepts the scene: Λ, and what
/// SystemEntry::refusal says. Call it once the system has checked its own fields.
void check_method_accepts_scene(SceneDraft& draft, const SystemInfo& system);

/// Whether a method, null for a discrete system, accepts a body in three dimensions given by
/// `body`.
bool accepts_body(const MethodEntry* method, const Body3& body, double step);

/// Whether the method of a description must be chosen for a tolerance before Scene::resolve accepts
/// it.
bool wants_choice(const SceneDescription& description);
/// Returns the violations that Scene::resolve finds in such a description, except that its method
/// is missing.
Violations check_before_choice(const SceneDescription& description, double largest_repair);

}  // namespace stiefel
