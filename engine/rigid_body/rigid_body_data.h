#pragma once

#include <array>

#include "engine/catalogue/methods/motion_rates.h"
#include "engine/catalogue/series_start.h"
#include "engine/catalogue/system_entry.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

extern const SeriesEquations body_equations;
extern const MotionRates body_rates;
extern const Packs body_packs;

/// Returns the data that rigid_body and moser_veselov share, the systems of (Q, M). Their check
/// accepts (Q, M), M alone, or a body in three dimensions given by `body`: inertia tensor or
/// moments, attitude quaternion, angular velocity.
SystemEntry rigid_body_family();

/// What moves rigid_body and moser_veselov, and their views.
Simulations rigid_body_simulations();
Simulations moser_veselov_simulations();

/// Checks Λ for n = N, and (Q, M), or M alone unless the frame is required.
void check_rigid_body(SceneDraft& draft, bool frame_required);

// Recommendations that several systems share. tests/engine/long/recommendation_for_long_test.cc
// measures their bounds (recommendation.h).

/// Whether a rigid body has a closed form.
bool has_closed_form(const Scene& scene);
inline constexpr Recommendation closed_form_of_body = {
    .where = "N = 3, or Lambda of at most two values",
    .takes = has_closed_form,
    .method = "exact",
    .arithmetic = "compensated"};
/// For bodies whose M is a product of the blocks; the error of M grows with the square of the time.
inline constexpr std::array for_products = {closed_form_of_body, with_error_control(5e-14)};
inline constexpr std::array for_views = {closed_form_of_body, with_error_control(1e-12, 0.15)};

}  // namespace stiefel
