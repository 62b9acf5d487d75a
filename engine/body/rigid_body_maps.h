#pragma once

#include "engine/body/exact/euler_top.h"
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
struct Variational::MapOf<RigidBody<Space>> {
  static constexpr bool keeps(std::string_view) { return true; }
  static MoserVeselov<Space> make(const RigidBody<Space>& body, typename Space::Scalar h,
                                  Arithmetic arithmetic) {
    if constexpr (HasMatrixStates<RigidBody<Space>>)
      return {body.lambda(), h, arithmetic};
    else
      return {body.lambda(), h, arithmetic, body.has_frame()};
  }
};

template <class Scalar, bool frame>
struct PreprocessedVariational::MapOf<RigidBody<So3<Scalar, frame>>> {
  struct type : PreprocessedMoserVeselov<Scalar, frame> {
    using Moved = PreprocessedMoserVeselov<Scalar, frame>;
    type(const RigidBody<So3<Scalar, frame>>& body, Scalar h, const MethodOptions& options)
        : Moved(body.lambda(), h, options.order, options.arithmetic, body.has_frame()) {}
  };
};

template <class Scalar, bool frame>
struct Splitting::MapOf<RigidBody<So3<Scalar, frame>>> {
  using type = SplitBody3<Scalar, frame>;
};

template <class Scalar, bool frame>
struct Exact::MotionOf<RigidBody<So3<Scalar, frame>>> {
  using Wide = Extended<Scalar>;
  static bool takes(const Eigen::VectorXd& lambda) { return lambda.size() == 3; }
  static EulerTop<Wide, frame> make(const RigidBody<So3<Scalar, frame>>& body,
                                    const typename So3<Scalar, frame>::State& start) {
    return {PrincipalMoments3<Wide>(body.lambda()), start.template cast<Wide>()};
  }
};

template <class Scalar>
struct Exact::MotionOf<RigidBody<SoN<Scalar>>> {
  using Wide = Extended<Scalar>;
  static constexpr std::string_view where = "N = 3, or Lambda of at most two values";
  static bool takes(const Eigen::VectorXd& lambda) {
    return lambda.size() == 3 || TwoValuedBody<Wide>::has(lambda);
  }
  static TwoValuedBody<Wide> make(const RigidBody<SoN<Scalar>>& body, const Matrix<Scalar>& start) {
    return {body.lambda().template cast<Wide>(), start.template cast<Wide>()};
  }
};

template <class Space>
struct ImplicitMidpoint::CayleyOf<RigidBody<Space>> {
  using type = CayleyMidpoint<Space>;
};

}  // namespace stiefel
