#pragma once

#include <array>

#include "engine/motion/body_view.h"
#include "engine/motion/representation.h"
#include "engine/motion/series_start.h"
#include "engine/motion/system_entry.h"
#include "engine/scene/scene_draft.h"

namespace stiefel {

extern const SeriesEquations body_equations, parametric_equations;
extern const MotionRates body_rates;
extern const Packs body_packs;

/// Returns the simulation of a rigid body by the scene's method; of the discrete body, whose map is
/// that of `variational` of order 2.
std::unique_ptr<Simulation> make_rigid_body(const Scene& scene);
/// Returns the methods that move rigid bodies, in the order of the catalogue.
std::vector<MethodOnSystem> methods_of_rigid_bodies(const SystemInfo& info);

/// Refuses a `body` and the numbers that only other systems have, all but these two for those that
/// have them. Takes Λ for n = N; returns false if there is none.
bool check_square_inertia(SceneDraft& draft, bool has_epsilon, bool has_parameter);
/// Checks Λ for n = N, and (Q, M), or M alone unless the frame is required.
void check_rigid_body(SceneDraft& draft, bool frame_required);
/// Checks Λ for n = N and the frame Q. Returns false if there is a violation.
bool check_symmetric_frame(SceneDraft& draft, bool has_epsilon);
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

/// The numbers of a scene on which the variables of a form depend.
template <class Scalar>
struct FormNumbers {
  explicit FormNumbers(const SceneNumbers<Scalar>& g)
      : lambda(g.lambda), epsilon(g.epsilon), step(g.scene.step()) {}

  Vector<Scalar> lambda;
  Scalar epsilon, step;
};

/// The rigid body in other variables: two blocks of these `names`, perhaps `right`-invariant.
///
///     body(a, b, numbers)   Q and M of the left-invariant body
///     blocks(scene)         for a view: the function that returns the two blocks of Q and M
template <class Form>
struct OtherVariables {
  static constexpr bool right = false;

  template <class Scalar>
  static auto body_of(const SceneNumbers<Scalar>& g) {
    return Form::body(g.block(Form::names[0]), g.block(Form::names[1]), FormNumbers<Scalar>(g));
  }
  struct Start {
    auto operator()(const auto& g) const {
      const auto [Q, M] = body_of(g);
      auto of_left = g.start(Q, M);
      of_left.reported.right = Form::right;
      return of_left;
    }
  };
  static Phase phase(const Scene& scene) {
    auto [Q, M] = body_of(SceneNumbers<double>(scene));
    return phase_of_body(scene, std::move(Q), std::move(M));
  }
  static BodyView view(const Scene& scene) {
    return {.body = [g = FormNumbers<double>(SceneNumbers<double>(scene))](
                        const BodyView::Two& x) { return Form::body(x[0], x[1], g); },
            .blocks = Form::blocks(scene)};
  }

  /// Returns the entry of a continuous system with `check` and `representation`.
  static SystemEntry entry(SystemInfo info) {
    return {.info = std::move(info),
            .check = Form::check,
            .make = make_rigid_body,
            .methods = methods_of_rigid_bodies,
            .recommended = for_views,
            .representation = &Form::representation,
            .view = view,
            .priced_as = "rigid_body",
            .motion = &in_both<body_equations, Start{}>,
            .rate = Rate::angular_speed,
            .packs = &body_packs,
            .rates = &body_rates};
  }
};

}  // namespace stiefel
