#pragma once

#include "engine/simulation/scene/scene_draft.h"

namespace stiefel {

/// Λ for n = N and (Q, P) or (Q, M), left- or right-invariant. Fills in the blocks Q and P, and
/// `epsilon`: as given; else 1 for P, `of_paper` if that is given; for M the power of two with
/// ½ < ε‖M‖_op ≤ 1 (scaling.h).
void check_symmetric(SceneDraft& draft, bool right, std::optional<double> of_paper = {});

/// (Q, B) with QᵀB skew, or (Q, M).
void check_mclachlan_scovel(SceneDraft& draft);

}  // namespace stiefel
