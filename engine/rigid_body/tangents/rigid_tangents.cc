#include "engine/rigid_body/tangents/rigid_tangents.h"

#include "engine/methods/exact.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/rk4.h"
#include "engine/methods/variational.h"

namespace stiefel {
namespace {

TangentSpace body_space(const Scene&) { return {}; }

constexpr MethodTangent of_methods[] = {
    {Exact::traits.name, exact_body_tangent, 3},
    {Variational::traits.name, discrete_body_tangent},
    {PreprocessedVariational::traits.name, discrete_body_tangent},
    {Rk4::traits.name, rk4_body_tangent}};
constexpr MethodTangent of_map[] = {{"", discrete_body_tangent}};

}  // namespace

const Tangents rigid_body_tangents = {body_space, of_methods};
const Tangents moser_veselov_tangents = {body_space, of_map};

}  // namespace stiefel
