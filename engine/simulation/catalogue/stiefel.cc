#include "engine/methods/special/stiefel.h"

#include "engine/representations/stiefel_momenta.h"
#include "engine/simulation/catalogue/coordinates/stiefel_in_float.h"
#include "engine/simulation/catalogue/families/forms.h"
#include "engine/simulation/catalogue/families/recommended.h"
#include "engine/simulation/catalogue/families/rigid_forms.h"
#include "engine/simulation/catalogue/families/stiefel_forms.h"
#include "engine/simulation/catalogue/motions/motion_starts.h"
#include "engine/simulation/catalogue/representations/representations.h"
#include "engine/simulation/stepping/make_simulation.h"
#include "engine/simulation/stepping/methods_on.h"

namespace stiefel {
namespace {

constexpr Eigen::Index largest_written_M = 4096;

std::unique_ptr<Simulation> make(const Scene& scene) {
  const Eigen::Index n = scene.Q().rows(), N = scene.dimension();
  StackedObservables observables(stacked(scene, "Q", "S"));
  observables.block("Q", 0, static_cast<int>(n));
  observables.block("S", static_cast<int>(n), static_cast<int>(n));
  report_geodesic(
      observables, scene, n, [n](const auto& x) { return x.bottomRows(n).eval(); },
      terms_of_S(scene, n, false));
  if (N <= largest_written_M)
    observables.field(
        {"M", static_cast<int>(N), static_cast<int>(N)},
        [n](const auto& x, auto out) { out = dense_M<double>(x.topRows(n), x.bottomRows(n)); });
  const auto fields = shared(std::move(observables));
  if (scene.in_float()) return stiefel_in_float(scene, fields);
  return make_simulation(scene, Stiefel<double>(scene.inertia(), n), fields,
                         stiefel_cost(n, N));
}

void check(SceneDraft& draft) {
  if (check_stiefel_frame(draft)) set_tangent(draft, "S", false);
}

bool is_isotropic(const Scene& scene) {
  return IsotropicGeodesic<long double>::has(scene.inertia());
}
bool in_the_plane(const Scene& scene) { return scene.dimension() == 2; }
Eigen::Index rows(const Scene& scene) { return scene.block("Q").rows(); }
bool has_whole_attitude(const Scene& scene) { return rows(scene) >= scene.dimension() - 1; }

/// The speed varies up to the root of λ_max/λ_min, and equal substeps that suffice for the fastest
/// passage cost more than steps that follow it.
bool is_one_point_in_a_wide_metric(const Scene& scene) {
  return is_one_point(scene) && scene.inertia().maxCoeff() > 10 * scene.inertia().minCoeff();
}
bool has_four_dimensions(const Scene& scene) { return scene.dimension() == 4; }

// With 1 < n < N - 1 most motions are chaotic: their condition is 1e6 and more after 100 rotations,
// and a larger tolerance suffices to keep the error below 1e-8 times the condition. A few, mostly
// in four dimensions, have a condition of only 100; for N > 4 the bound on the step suffices for
// them.
constexpr std::array recommendations = {
    Recommendation{.where = "Lambda a multiple of the identity",
                   .takes = is_isotropic,
                   .method = Exact::traits.name,
                   .arithmetic = "compensated"},
    restricted("N = 2", in_the_plane, with_error_control(2e-13, 0.12)),
    restricted("n >= N - 1", has_whole_attitude, with_error_control(5e-14, 0.12)),
    restricted("n = 1, Lambda over more than 1:10", is_one_point_in_a_wide_metric,
               with_error_control(5e-13, 0.15)),
    Recommendation{.where = "n = 1",
                   .takes = is_one_point,
                   .method = Variational::traits.name,
                   .order = 8,
                   .largest_h_velocity_rate = 0.3},
    restricted("N = 4", has_four_dimensions, with_error_control(5e-13, 0.15)),
    with_error_control(2e-12, 0.14)};

}  // namespace

SystemEntry stiefel_entry() {
  SystemInfo info = stiefel_info({"S", "n x N", true, "S = Q' Lambda"});
  info.fields.push_back({"M", "N x N", "M = Q^T S - S^T Q, N <= 4096"});
  info.name = "stiefel";
  info.summary = "geodesics on the Stiefel manifold V(n, N) with the metric of Lambda";
  info.equations = "Q' = S Lambda^-1, S' = B Q, K B + B K = -2 Q' Q'^T, K = Q Lambda^-1 Q^T";
  info.source = "[ST] (37)-(39)";
  info.file = "engine/systems/stiefel.h";
  info.methods = methods_on<Stiefel<double>>(info);
  offer_in_float(info);
  return {.info = info,
          .check = check,
          .make = make,
          .recommended = recommendations,
          .two_forms = {&two_form::of_tangent_pairs, &two_form::of_cotangent_pairs},
          .representation = &representation::tangent,
          .motion = &motion_start::tangent,
          .rate = Rate::frame_speed};
}

}  // namespace stiefel
