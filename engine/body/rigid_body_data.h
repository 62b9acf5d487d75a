#pragma once

#include <array>

#include "engine/motion/motion_rates.h"
#include "engine/motion/series_start.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

extern const SeriesEquations body_equations;
extern const MotionRates body_rates;
extern const Packs body_packs;

/// Returns the simulation of a rigid body by the scene's method; of the discrete body, whose map is
/// that of `variational` of order 2.
std::unique_ptr<Simulation> make_rigid_body(const Scene& scene);
/// Returns the methods that move rigid bodies, in the order of the catalogue.
std::vector<MethodOnSystem> methods_of_rigid_bodies(const SystemInfo& info);

/// Returns the entry of a continuous system that is the rigid body in other variables.
SystemEntry view_of_rigid_body(SystemInfo info, void (*check)(SceneDraft&),
                               const Representation& representation, BodyView (*view)(const Scene&),
                               const MotionStart& motion);

/// Checks Λ for n = N, and (Q, M), or M alone unless the frame is required.
void check_rigid_body(SceneDraft& draft, bool frame_required);

/// Checks Λ for n = N and the frame Q. Returns false if there is a violation.
bool check_symmetric_frame(SceneDraft& draft);
/// Checks that the scene has exactly one of the two blocks.
bool check_either(SceneDraft& draft, const std::string& one, const std::string& other);

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
