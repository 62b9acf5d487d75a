#pragma once

#include "engine/rigid_body/body/rigid_body.h"
#include "engine/stepping/tangent_map_of.h"

namespace stiefel {

// The tangents of the rigid body in dual numbers, divided among files by what takes long to
// compile.

/// Of the closed forms.
std::unique_ptr<TangentMap> exact_body_tangent(const Scene& scene, const TangentParameters& at);
/// Of other methods in three dimensions.
std::unique_ptr<TangentMap> dual_body_tangent_3(const Scene& scene, const TangentParameters& at);

/// Returns the tangents of a body by the scene's method, one of `Methods`; null if it is none.
template <class Space, class... Methods>
std::unique_ptr<TangentMap> body_tangent_by(const Scene& scene, const TangentParameters& at) {
  using Body = RigidBody<Space>;
  const Body body(typename Space::Lambda(at.lambda), scene.has_frame());
  std::unique_ptr<TangentMap> made;
  for_each_type(TypeList<Methods...>{}, [&]<class Method>(Method*) {
    if (scene.method() != Method::traits.name) return;
    // Two conditions: clang instantiates both branches of one that depends on `Method`.
    if constexpr (!HasMatrixStates<Body>)
      made = make_tangent_by<Method>(scene, body, at.h);
    else if constexpr (has_map_for<Method, Body>)
      made = make_tangent_by<Method>(scene, body, at.h);
    else
      made = make_general_tangent(scene, body, at.h);
  });
  return made;
}

}  // namespace stiefel
