#pragma once

#include "engine/scene/scene_draft.h"

namespace stiefel {

/// Checks Λ for n = N and (Q, P) or (Q, M), left- or right-invariant. Fills in the blocks Q and P,
/// and `epsilon` if it is absent: with P it is `of_paper` if that is given, else 1; with M it is
/// the power of two with ½ < ε‖M‖_op ≤ 1 (scaling.h).
void check_symmetric(SceneDraft& draft, bool right, std::optional<double> of_paper = {});

/// Checks (Q, B) with QᵀB skew, or (Q, M).
void check_mclachlan_scovel(SceneDraft& draft);

}  // namespace stiefel
