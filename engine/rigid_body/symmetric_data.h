#pragma once

#include "engine/rigid_body/rigid_forms.h"
#include "engine/rigid_body/view.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

/// Returns the data that the systems of (Q, P) share, left- or right-invariant.
SystemEntry symmetric_family(Side side = Side::left);

/// Checks Λ for n = N and the frame Q. Returns false if there is a violation.
bool check_symmetric_frame(SceneDraft& draft);
/// Checks that the scene has exactly one of the two blocks.
bool check_either(SceneDraft& draft, const std::string& one, const std::string& other);

/// Checks Λ for n = N and (Q, P) or (Q, M), left- or right-invariant. Fills in the blocks Q and P,
/// and `epsilon` if it is absent: with P it is `of_paper` if that is given, else 1; with M it is
/// the power of two with ½ < ε‖M‖_op ≤ 1 (scaling.h).
void check_symmetric(SceneDraft& draft, bool right, std::optional<double> of_paper = {});

/// Returns the view of (Q, P), left- or right-invariant as its system: M = Ψ(Q, P) on the left, P =
/// AQ with the constant A = PQᵀ of the scene, [RB] (8.2).
BodyView view_of_pair(const Scene& scene);

/// Makes the entry of a system of (Q, P) that of this view.
void as_view_of_pair(SystemEntry& entry);

/// Returns the observables of (Q, P), stacked to 2N × N: the blocks, M = (QᵀP − PᵀQ)/ε, the
/// constant PQᵀ, and the invariants of M.
StackedObservables symmetric_observables(const Scene& scene);

}  // namespace stiefel
