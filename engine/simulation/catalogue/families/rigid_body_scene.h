#pragma once

#include "engine/simulation/scene/scene_draft.h"

namespace stiefel {

/// Λ for n = N, and (Q, M), or M alone where that is allowed.
void check_rigid_body(SceneDraft& draft, bool frame_required);

/// (Q, M), M alone, or a body in three dimensions as engineers give it.
void check_rigid_body_or_engineers(SceneDraft& draft);

/// Refuses everything that scenes of (Q, M) do not have.
void check_no_extras(SceneDraft& draft);

}  // namespace stiefel
