#pragma once

#include "engine/body/exact/euler_top.h"
#include "engine/body/exact/turned_body.h"
#include "engine/body/exact/two_valued_body.h"
#include "engine/body/moser_veselov.h"
#include "engine/body/preprocessed_moser_veselov.h"
#include "engine/body/rigid_body.h"
#include "engine/body/split_body_3.h"
#include "engine/dense/cayley_midpoint.h"
#include "engine/methods/exact.h"
#include "engine/methods/implicit_midpoint.h"
#include "engine/methods/matrix_system.h"
#include "engine/methods/preprocessed_variational.h"
#include "engine/methods/splitting.h"
#include "engine/methods/variational.h"

namespace stiefel {

// The maps of methods that are made for the left-invariant rigid body.

template <class Space>
auto map_of(Variational, const RigidBody<Space>& body, typename Space::Scalar h,
            const MethodOptions& options) {
  return composed(
      [body](typename Space::Scalar stage, Arithmetic arithmetic) -> MoserVeselov<Space> {
        if constexpr (HasMatrixStates<RigidBody<Space>>)
          return {body.lambda(), stage, arithmetic};
        else
          return {body.lambda(), stage, arithmetic, body.has_frame()};
      },
      h, options);
}

template <class Scalar, bool frame>
PreprocessedMoserVeselov<Scalar, frame> map_of(PreprocessedVariational,
                                               const RigidBody<So3<Scalar, frame>>& body, Scalar h,
                                               const MethodOptions& options) {
  return {body.lambda(), h, options.arithmetic, options.order, body.has_frame()};
}

template <class Scalar, bool frame>
SplitBody3<Scalar, frame> map_of(Splitting, const RigidBody<So3<Scalar, frame>>& body, Scalar h,
                                 const MethodOptions& options) {
  return {body, h, options};
}

template <class Space>
ImplicitMidpoint::Map<RigidBody<Space>, CayleyMidpoint<Space>> map_of(
    ImplicitMidpoint, const RigidBody<Space>& body, typename Space::Scalar h,
    const MethodOptions& options) {
  return {body, h, options};
}

/// Bodies of scenes in three dimensions have more digits of Λ and M (exact_body.cc).
template <class Scalar, bool frame>
auto map_of(Exact, const RigidBody<So3<Scalar, frame>>& body, Scalar h, const MethodOptions&) {
  using Wide = Extended<Scalar>;
  using Point = typename So3<Scalar, frame>::State;
  return closed_form_map<Point>(
      [body](const Point& start) {
        return EulerTop<Wide, frame>(PrincipalMoments3<Wide>(body.lambda()),
                                     start.template cast<Wide>());
      },
      h);
}

template <class Scalar>
auto map_of(Exact, const RigidBody<SoN<Scalar>>& body, Scalar h, const MethodOptions&) {
  using Wide = Extended<Scalar>;
  return closed_form_map<Matrix<Scalar>>(
      [body](const Matrix<Scalar>& start) {
        return TwoValuedBody<Wide>(body.lambda().template cast<Wide>(),
                                   start.template cast<Wide>());
      },
      h);
}
template <class Scalar>
inline constexpr Declared declared<Exact, RigidBody<SoN<Scalar>>> = {
    .where = "N = 3, or Lambda of at most two values", .takes = BodyRotation::has};

}  // namespace stiefel
