#pragma once

#include "engine/scene/scene_draft.h"

namespace stiefel {

/// Checks the method of a draft, which must have one, against those of a continuous system, and
/// fills in what it leaves open: order, substeps, tolerance, arithmetic, scalar.
void check_method(SceneDraft& draft, const SystemInfo& system);

/// Checks that the method of a draft, if it has one, accepts the scene: Λ, and what
/// Simulations::refusal says. Call it once the system has checked its own fields.
void check_method_accepts_scene(SceneDraft& draft, const SystemInfo& system);

}  // namespace stiefel
