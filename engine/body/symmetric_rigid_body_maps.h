#pragma once

#include "engine/body/exact/turned_body.h"
#include "engine/body/psi.h"
#include "engine/body/symmetric_moser_veselov.h"
#include "engine/body/symmetric_rigid_body.h"
#include "engine/methods/exact.h"
#include "engine/methods/variational.h"

namespace stiefel {

// The maps of methods that are made for the symmetric representation: (SDRBn), which is the
// Moser–Veselov map under Ψ, and the closed form.

template <class Scalar>
struct Variational::MapOf<SymmetricRigidBody<Scalar>> {
  static constexpr bool keeps(std::string_view) { return true; }
  static SymmetricMoserVeselov<Scalar> make(const SymmetricRigidBody<Scalar>& body, Scalar h,
                                            Arithmetic arithmetic) {
    return {body.lambda(), h, body.epsilon(), arithmetic};
  }
};

template <class Scalar>
struct Exact::MotionOf<SymmetricRigidBody<Scalar>> {
  using Wide = Extended<Scalar>;
  static constexpr std::string_view where = "N = 3, or Lambda of at most two values";
  static bool takes(const Eigen::VectorXd& lambda) { return BodyRotation<Wide>::has(lambda); }

  static TurnedBody<Wide> make(const SymmetricRigidBody<Scalar>& body,
                               const Matrix<Scalar>& start) {
    const Matrix<Wide> x = start.template cast<Wide>();
    const Matrix<Wide> Q = x.topRows(x.cols()), P = x.bottomRows(x.cols());
    const Wide epsilon = body.epsilon();
    return {{body.lambda().template cast<Wide>(), Psi(Q, P, epsilon)}, x};
  }
};

template <class Scalar>
struct SpecialMethods<SymmetricRigidBody<Scalar>> {
  using type = TypeList<Variational, Exact>;
};

}  // namespace stiefel
