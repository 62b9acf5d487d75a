// The recommended methods of every continuous system, as data. What recommendation.h says of them
// is measured by tests/engine/recommendation_for_long_test.cc.
#include <array>

#include "engine/methods/closed_forms/isotropic_geodesic.h"
#include "engine/methods/closed_forms/two_valued_body.h"
#include "engine/simulation/catalogue/recommendation.h"
#include "stiefel/scene.h"

namespace stiefel {
namespace {

bool in_three(const Scene& scene) { return scene.dimension() == 3; }
bool is_4d(const Scene& scene) { return scene.dimension() == 4; }
bool is_4d_without_frame(const Scene& scene) { return is_4d(scene) && !scene.has_frame(); }

/// Ω is constant: a step by the exponential is exact.
bool turns_evenly(const Scene& scene) {
  const Eigen::VectorXd& lambda = scene.inertia();
  return lambda.size() == 2 || (lambda.array() == lambda(0)).all();
}
bool stands_still(const Scene& scene) { return turns_evenly(scene) && !scene.has_frame(); }
bool of_two_values(const Scene& scene) { return TwoValuedBody<long double>::has(scene.inertia()); }
bool is_round(const Scene& scene) { return IsotropicGeodesic<long double>::has(scene.inertia()); }
bool has_costate(const Scene& scene) { return scene.block("p").size() > 0; }

/// In longer steps rounding would exceed what the tolerance leaves to a stride.
constexpr double longest = 0.5;
constexpr Recommendation adaptive(double tolerance, double largest_h_omega = longest) {
  return {
      .method = "adaptive", .order = 8, .tolerance = tolerance, .largest_h_omega = largest_h_omega};
}
constexpr Recommendation at_constant_Omega = {
    .where = "N = 2, or Lambda a multiple of the identity",
    .takes = turns_evenly,
    .method = "munthe_kaas4",
    .order = 4};

constexpr std::array rigid_body = {
    Recommendation{.where = "N = 3",
                   .takes = in_three,
                   .method = "preprocessed_variational",
                   .order = 14,
                   .largest_h_omega = 0.3},
    Recommendation{.where = "without Q, N = 2 or Lambda a multiple of the identity",
                   .takes = stands_still,
                   .method = "variational",
                   .order = 2},
    Recommendation{.where = "Lambda of at most two values",
                   .takes = of_two_values,
                   .method = "exact",
                   .arithmetic = "compensated"},
    Recommendation{.where = "N = 4, without Q",
                   .takes = is_4d_without_frame,
                   .method = "rk4",
                   .order = 4,
                   .largest_h_momentum_rate = 0.0037},
    Recommendation{.where = "N = 4",
                   .takes = is_4d,
                   .method = "variational",
                   .order = 8,
                   .largest_h_omega = 0.15},
    adaptive(1e-12, 0.15)};

constexpr std::array right_rigid_body = {at_constant_Omega, adaptive(1e-12, 0.15)};
/// M is a product of what is moved: its error grows with the square of the time.
constexpr std::array other_forms = {at_constant_Omega, adaptive(2e-13)};
constexpr std::array parametric = {at_constant_Omega, adaptive(5e-14, 0.1)};
constexpr std::array stiefel_frames = {Recommendation{.where = "Lambda a multiple of the identity",
                                                      .takes = is_round,
                                                      .method = "exact",
                                                      .arithmetic = "compensated"},
                                       adaptive(5e-14, 0.1)};
constexpr std::array costates = {adaptive(1e-11, 0.15)};
constexpr std::array ellipsoid = {Recommendation{.where = "given p",
                                                 .takes = has_costate,
                                                 .method = "adaptive",
                                                 .order = 8,
                                                 .tolerance = 1e-11,
                                                 .largest_h_omega = 0.15},
                                  adaptive(1e-13)};
constexpr std::array double_bracket = {adaptive(3e-13)};

struct OfSystem {
  std::string_view system;
  std::span<const Recommendation> recommended;
};
constexpr OfSystem table[] = {{"rigid_body", rigid_body},
                              {"right_rigid_body", right_rigid_body},
                              {"symmetric_rigid_body", other_forms},
                              {"right_symmetric_rigid_body", other_forms},
                              {"reduced_rigid_body", other_forms},
                              {"mclachlan_scovel", other_forms},
                              {"parametric_rigid_body", parametric},
                              {"stiefel", stiefel_frames},
                              {"stiefel_momentum", costates},
                              {"stiefel_costate", costates},
                              {"ellipsoid", ellipsoid},
                              {"double_bracket", double_bracket}};

}  // namespace

std::span<const Recommendation> recommended(std::string_view system) {
  for (const OfSystem& entry : table)
    if (entry.system == system) return entry.recommended;
  return {};
}

}  // namespace stiefel
