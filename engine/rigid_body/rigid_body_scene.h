#pragma once

#include "engine/scene/scene_draft.h"

namespace stiefel {

/// Checks Λ for n = N, and (Q, M), or M alone unless the frame is required.
void check_rigid_body(SceneDraft& draft, bool frame_required);

/// Checks (Q, M), M alone, or a body in three dimensions given by `body`: inertia tensor or
/// moments, attitude quaternion, angular velocity.
void check_rigid_body_or_engineers(SceneDraft& draft);

/// Refuses everything that scenes of (Q, M) do not have.
void check_no_extras(SceneDraft& draft);

}  // namespace stiefel
