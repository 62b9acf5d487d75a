#include "engine/linalg/iteration/dual_iterations.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/rk4.h"
#include "engine/methods/variational.h"
#include "engine/rigid_body/maps/rigid_body_maps.h"
#include "engine/rigid_body/symmetric/dual_psi.h"
#include "engine/rigid_body/tangents/column_tangents.h"
#include "engine/rigid_body/tangents/dual_body_tangents.h"

namespace stiefel {
namespace {

TangentSpace body_space(const Scene&) { return {TangentSpace::Coordinates::left_body, {}}; }

std::unique_ptr<TangentMap> make(const Scene& scene, const TangentParameters& at) {
  if (scene.method() == Exact::traits.name) return exact_body_tangent(scene, at);
  if (scene.dimension() == 3) return dual_body_tangent_3(scene, at);
  return body_tangent_by<SoN<Tangent>, MuntheKaas4, ImplicitMidpoint, Gauss4, Rk4>(scene, at);
}

bool has_columns(const Scene& scene) {
  constexpr Eigen::Index largest_of_rk4 = 10;
  if (scene.method() == Rk4::traits.name) return scene.dimension() <= largest_of_rk4;
  return scene.method().empty() || scene.method() == Variational::traits.name ||
         scene.method() == PreprocessedVariational::traits.name;
}

std::unique_ptr<TangentMap> make_columns(const Scene& scene, const ColumnParameters& at) {
  if (scene.method() != Rk4::traits.name) return discrete_body_tangent(scene, at);
  return scene.dimension() == 3 ? rk4_body_tangent_3(scene, at) : rk4_body_tangent(scene, at);
}

}  // namespace

Tangents rigid_body_tangents() { return {body_space, make, has_columns, make_columns}; }
Tangents moser_veselov_tangents() { return {body_space, make, has_columns, make_columns}; }

}  // namespace stiefel
