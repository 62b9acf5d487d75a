#include <string_view>

#include "engine/methods/gauss4.h"
#include "engine/methods/munthe_kaas4.h"
#include "engine/methods/rk4.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {
namespace {

/// The general methods of a fixed step. A method that chooses its own substeps has no tangent: the
/// choice is no smooth function of the state.
using Methods = TypeList<MuntheKaas4, Gauss4, Rk4>;

}  // namespace

GeneralTangents general_tangents(std::string_view name) {
  using ByField = MatrixSystem<Tangent>;
  using ByAction = MatrixLieSystem<Tangent>;
  GeneralTangents made;
  for_each_type(Methods{}, [&]<class Method>(Method*) {
    if (name != Method::traits.name) return;
    if constexpr (requires { typename Method::template Map<ByField>; })
      made.by_field = make_tangent_by<Method, ByField>;
    else
      made.by_action = make_tangent_by<Method, ByAction>;
  });
  return made;
}

}  // namespace stiefel
